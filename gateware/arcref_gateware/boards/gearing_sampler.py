"""Two or four samples a word on the ECP5: the input gearing of the I/O cells, IDDRX1F and IDDRX2F.

IDDRX2F takes a sample with each edge of the edge clock and hands over four of them with each word clock, Q0 the
oldest; IDDRX1F does the same for two with the word clock itself (Lattice FPGA-TN-02035, ECP5 high-speed I/O:
"GDDRX2_RX.ECLK" and the waveforms of IDDRX1F and IDDRX2F).
"""

from amaranth.hdl import Cat, ClockSignal, Const, Instance, Module, Signal
from amaranth.lib import io, wiring
from amaranth.lib.wiring import In, Out


class GearingSampler(wiring.Component):
    """Samples every port of `ports` (name -> port); a word of 2 or 4 samples each clock of the domain `word`.

    The word of a line is the output of its name, bit 0 the oldest. Four samples need the domain `edge` at twice the
    word clock. A port named in `driven` also sends the level of the input `NAME_out` while `NAME_drive` is 1: the
    pad of the alignment check.
    """

    def __init__(self, ports: dict, samples_per_word: int, driven: tuple[str, ...] = ()):
        if samples_per_word not in (2, 4):
            raise ValueError(f"the gearing brings 2 or 4 samples a word, not {samples_per_word!r}")
        self.ports = ports
        self.samples_per_word = samples_per_word
        self.driven = driven
        members = {name: Out(samples_per_word) for name in ports} | {"reset": In(1)}
        for name in driven:
            members |= {f"{name}_out": In(1), f"{name}_drive": In(1)}
        super().__init__(members)

    reset: In
    """Reset of the gearing, asynchronous; released while the edge clock stands still."""

    def elaborate(self, platform):
        m = Module()
        for name, port in self.ports.items():
            pad = port.p if isinstance(port, io.DifferentialPort) else port.io
            level = Signal(name=f"{name}_level")
            if name in self.driven:
                m.submodules[f"{name}_pad"] = Instance(
                    "BB",
                    i_T=~getattr(self, f"{name}_drive"),
                    i_I=getattr(self, f"{name}_out"),
                    o_O=level,
                    io_B=pad,
                )
            else:
                m.submodules[f"{name}_pad"] = Instance("IB", i_I=pad, o_O=level)
            samples = [Signal(name=f"{name}_sample_{k}") for k in range(self.samples_per_word)]
            m.submodules[f"{name}_gearing"] = self._gearing(level, samples)
            inverted = Const((1 << self.samples_per_word) - 1 if port.invert[0] else 0, self.samples_per_word)
            m.d.word += getattr(self, name).eq(Cat(samples) ^ inverted)
        return m

    def _gearing(self, level, samples) -> Instance:
        outputs = {f"o_Q{k}": sample for k, sample in enumerate(samples)}
        clocks = {"i_SCLK": ClockSignal("word"), "i_RST": self.reset}
        if self.samples_per_word == 2:
            return Instance("IDDRX1F", i_D=level, **clocks, **outputs)
        return Instance("IDDRX2F", i_D=level, i_ECLK=ClockSignal("edge"), **clocks, **outputs)
