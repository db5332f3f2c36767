"""The simulation floor: a synthetic encoder that knows the truth, and the core compiled with Verilator."""
