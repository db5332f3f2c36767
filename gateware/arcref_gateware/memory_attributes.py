"""Attributes of memories for synthesis."""

NO_COLLISION = {"no_rw_check": 1}
"""For a memory that is never read where it is being written, or whose reader does not mind what it gets there:
synthesis then builds no logic for that case, which an iCE40's block RAM would need.
It heeds the attribute only where the memory's output register is a plain one behind a port without a clock."""
