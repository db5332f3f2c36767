"""The zero-return test's result, table, plots and page, the same for the simulation and for an instrument."""
