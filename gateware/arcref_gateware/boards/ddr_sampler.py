"""Two samples a word on the iCE40: the double-data-rate registers of SB_IO.

SB_IO registers the pad with the rising edge (D_IN_0) and with the falling edge (D_IN_1); `io.DDRBuffer` takes both
over with the next rising edge, so the sample of the rising edge is the older one (Lattice, iCE40 Technology Library,
SB_IO, PIN_TYPE 00).
"""

from amaranth.hdl import Cat, Module
from amaranth.lib import io, wiring
from amaranth.lib.wiring import In, Out


class DdrSampler(wiring.Component):
    """Samples every port of `ports` (name -> port) with both edges of the domain `word`.

    The word of a line is the output of its name, bit 0 the oldest. A port named in `driven` also sends the samples
    of the input `NAME_out` while `NAME_drive` is 1: the pad of the alignment check.
    """

    def __init__(self, ports: dict, driven: tuple[str, ...] = ()):
        self.ports = ports
        self.driven = driven
        members = {name: Out(2) for name in ports}
        for name in driven:
            members |= {f"{name}_out": In(2), f"{name}_drive": In(1)}
        super().__init__(members)

    def elaborate(self, platform):
        m = Module()
        for name, port in self.ports.items():
            if name in self.driven:
                buffer = io.DDRBuffer("io", port, i_domain="word", o_domain="word")
                samples = getattr(self, f"{name}_out")
                m.d.comb += [
                    buffer.o[0].eq(samples[0]),
                    buffer.o[1].eq(samples[1]),
                    buffer.oe.eq(getattr(self, f"{name}_drive")),
                ]
            else:
                buffer = io.DDRBuffer("i", port, i_domain="word")
            m.submodules[name] = buffer
            m.d.word += getattr(self, name).eq(Cat(buffer.i[0], buffer.i[1]))
        return m
