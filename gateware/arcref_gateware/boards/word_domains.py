"""The two clock domains of the word clock: `word` runs once the clock is there, `sync` once it can be trusted.

Both have the very same clock signal and differ in their reset: the core, in `sync`, is held until the alignment
check, in `word`, has passed.
"""

from amaranth.hdl import ClockDomain, Module, Signal


def add_word_domains(m: Module) -> Signal:
    """Add the domains `word` and `sync` to `m`, with one clock and a reset of their own each; gives that clock."""
    word, core = ClockDomain("word"), ClockDomain("sync")
    core.clk = word.clk
    m.domains.word = word
    m.domains.sync = core
    return word.clk
