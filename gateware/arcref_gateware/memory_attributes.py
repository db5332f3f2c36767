"""Attributes of memories for synthesis."""

NO_COLLISION = {"no_rw_check": 1}
"""For a memory that is never read where it is being written, or whose reader does not mind what it gets there:
synthesis then builds no logic for that case, which an iCE40's block RAM would need.
It heeds the attribute only where the memory's output register is a plain one behind a port without a clock."""

OUTPUT_REGISTER = {"memory_output_register": 1}
"""For the first register behind a memory, which synthesis takes into the block RAM. What it holds at power-up must not
matter: `FORGET_INITIAL_VALUES` makes it undefined, else synthesis would build logic that shows a 0 for a clock."""

FORGET_INITIAL_VALUES = f"setattr -unset init a:{next(iter(OUTPUT_REGISTER))}=1"
"""What synthesis must be told after reading the design."""
