"""The golden model: what every block of the core must do, in short NumPy code with no notion of clocks.

Amaranth's simulator, the cocotb benches and the long native runs are all held against it, bit for bit.
"""
