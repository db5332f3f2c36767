"""One sample a word: an input register in the I/O cell and one behind it, for each line alike."""

from amaranth.hdl import Module
from amaranth.lib import io, wiring
from amaranth.lib.wiring import Out

PLAIN_CLOCKS = 1
"""Clocks behind the I/O cell's own register."""


class PlainSampler(wiring.Component):
    """Samples every port of `ports` (name -> port) with each rising edge of the domain `word`.

    The word of a line is the output of its name, one bit. The register behind the I/O cell settles what the first
    one caught in mid-edge.
    """

    def __init__(self, ports: dict):
        self.ports = ports
        super().__init__({name: Out(1) for name in ports})

    def elaborate(self, platform):
        m = Module()
        for name, port in self.ports.items():
            m.submodules[name] = buffer = io.FFBuffer("i", port, i_domain="word")
            m.d.word += getattr(self, name).eq(buffer.i)
        return m
