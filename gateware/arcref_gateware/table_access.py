"""How trial tables get into the core, and how the identity is read."""

from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out


class TableAccess(wiring.Signature):
    """Members as the one who loads sees them. While `loading` the tables serve nothing else."""

    def __init__(self):
        super().__init__(
            {
                "loading": Out(1),
                "hold": Out(1),
                "check": Out(1),
                "address": Out(12),
                "write_line": Out(1),
                "write_subdivision": Out(1),
                "write_identity": Out(1),
                "write_word": Out(16),
                "identity_word": In(16),
                "crc32": In(32),
                "checking": In(1),
                "good": In(1),
            }
        )
