"""The two clock domains of the word clock: `word` runs once the clock is there, `sync` once it can be trusted.

Both have the very same clock signal and differ in their reset: the core, in `sync`, is held until the alignment
check, in `word`, has passed.
"""

from amaranth.hdl import ClockDomain, Module


def add_word_domains(m: Module) -> None:
    """Add the domains `word` and `sync` to `m`, with one clock and a reset of their own each."""
    word, core = ClockDomain("word"), ClockDomain("sync")
    core.clk = word.clk
    m.domains.word = word
    m.domains.sync = core
