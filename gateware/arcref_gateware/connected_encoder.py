"""The core with its wire: registers behind UART and SPI, captures, strobe sources, compare output, trial tables."""

from amaranth.hdl import Cat, Const, Module, Mux, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out, connect

from arcref.correction_rom import CorrectionRom
from arcref.link.packet import DEFAULT_BAUD
from arcref.link.registers import GATEWARE_VERSION, MAGIC, PROTOCOL_VERSION, REGISTERS, fault_key
from arcref_gateware.link.baud_rate import baud_divisor
from arcref_gateware.link.capture_fifo import CaptureFifo
from arcref_gateware.link.compare_output import CompareOutput
from arcref_gateware.link.fault_counter import FaultCounter
from arcref_gateware.link.register_file import RegisterFile
from arcref_gateware.link.register_layout import TALLY_BITS, fault_flags
from arcref_gateware.link.spi_door import SpiDoor
from arcref_gateware.link.status_recorder import StatusRecorder
from arcref_gateware.link.strobe_source import StrobeSource
from arcref_gateware.link.trial_tables import TrialTables
from arcref_gateware.link.uart_door import UartDoor
from arcref_gateware.quadrature import DEFAULT_GATE_STATE
from arcref_gateware.reference_encoder import ReferenceEncoder

DEFAULT_WORD_CLOCK_HZ = 200e6
CAPTURE_DEPTH = 256
"""Captures that the FIFO holds when nobody says otherwise."""

CORE_INPUTS = ("a", "b", "z", "spi_sck", "spi_cs_n", "spi_copi")
CORE_OUTPUTS = (
    "raw_position",
    "position",
    "homed",
    "illegal_steps",
    "closure_error",
    "largest_closure_error",
    "index_count",
    "flags",
    "capture_valid",
    "capture_position",
    "capture_raw",
    "capture_time",
    "shortest_edge_spacing",
    "first_illegal_position",
    "first_illegal_time",
    "spi_cipo",
)


class ConnectedEncoder(wiring.Component):
    """`ReferenceEncoder` and everything by which it is set, read and captured.

    Parameters: those of the core; `word_clock_hz`, which the registers state and the baud rate is made from; `baud`;
    `capture_depth`, the captures that the FIFO holds, a power of two: up to 256 take eight block RAMs of an iCE40, up
    to 1024 eight of an ECP5; `settings`: reset values of registers other than the declaration's.
    Raises ValueError for a baud rate that the clock cannot give. The ports of the core mean what they mean there.
    """

    def __init__(
        self,
        rom: CorrectionRom | None,
        samples_per_word: int = 4,
        *,
        gate_state: tuple[int, int] = DEFAULT_GATE_STATE,
        strobe_delay: int = 0,
        word_clock_hz: float = DEFAULT_WORD_CLOCK_HZ,
        baud: float = DEFAULT_BAUD,
        capture_depth: int = CAPTURE_DEPTH,
        has_test_generator: bool = False,
        settings: dict[str, int] | None = None,
    ):
        self.core = ReferenceEncoder(rom, samples_per_word, gate_state=gate_state, strobe_delay=strobe_delay)
        self.rom, self.samples_per_word = rom, samples_per_word
        self.gate_state_init, self.strobe_delay_init = gate_state, strobe_delay
        self.word_clock_hz, self.baud = word_clock_hz, baud
        self.divisor = baud_divisor(word_clock_hz, baud)
        self.capture_depth = capture_depth
        self.has_test_generator = has_test_generator
        constants = {
            "magic": MAGIC,
            "protocol": PROTOCOL_VERSION,
            "gateware": GATEWARE_VERSION,
            "samples_per_word": samples_per_word,
            "word_clock_hz": round(word_clock_hz),
            "capture_depth": capture_depth,
            "features": int(has_test_generator),
        }
        resets = {"strobe_delay": strobe_delay, "gate_state": gate_state[0] | gate_state[1] << 1}
        self.registers = RegisterFile(constants, resets | (settings or {}))
        members = self.core.signature.members
        super().__init__(
            {name: members[name] for name in (*CORE_INPUTS, "strobe", *CORE_OUTPUTS)}
            | {
                "uart_rx": In(1, init=1),
                "uart_tx": Out(1, init=1),
                "compare": Out(1),
                "generator_control": Out(REGISTERS["generator_control"].width),
                "generator_rate": Out(REGISTERS["generator_rate"].width),
            }
        )

    uart_rx: In
    """UART from the host, asynchronous: 8 data bits, no parity, one stop bit."""
    uart_tx: Out
    """UART to the host."""
    compare: Out
    """The compare output: a pulse every so many counts of corrected position."""
    generator_control: Out
    """The register of that name, for the test generator outside."""
    generator_rate: Out
    """The register of that name."""

    def elaborate(self, platform):
        m = Module()
        m.submodules.core = core = self.core
        m.submodules.registers = file = self.registers
        m.submodules.uart_door = uart = UartDoor(self.divisor)
        m.submodules.spi_door = spi = SpiDoor()
        m.submodules.strobe_source = source = StrobeSource(self.samples_per_word)
        m.submodules.capture_fifo = fifo = CaptureFifo(self.capture_depth)
        m.submodules.compare_output = compare = CompareOutput()
        m.submodules.status_recorder = recorder = StatusRecorder()
        m.submodules.trial_tables = trial = TrialTables()

        m.d.comb += [getattr(core, name).eq(getattr(self, name)) for name in CORE_INPUTS]
        m.d.comb += [getattr(self, name).eq(getattr(core, name)) for name in CORE_OUTPUTS]
        m.d.comb += [
            core.strobe.eq(source.strobe),
            source.pin.eq(self.strobe),
            source.chip_select.eq(core.chip_select),
            source.control.eq(file.strobe_control),
            source.period.eq(file.strobe_period),
            source.command.eq(file.strobe_command),
            core.strobe_delay.eq(file.strobe_delay),
            core.gate_state.eq(file.gate_state),
            core.rehome.eq(file.home),
            core.correction_enable.eq(file.correction_enable),
            core.clear_flags.eq(file.clear_flags),
        ]
        self._join_doors(m, file, uart, spi)
        connect(m, core.spi_registers, spi.registers)
        connect(m, trial.access, core.tables)
        connect(m, uart.capture, fifo.oldest)

        time = Cat(Const(self.samples_per_word - 1, self.samples_per_word.bit_length() - 1), core.words)
        m.d.comb += [
            uart.rx.eq(self.uart_rx),
            self.uart_tx.eq(uart.tx),
            fifo.valid.eq(core.capture_valid),
            fifo.time.eq(core.capture_time),
            fifo.raw.eq(core.capture_raw),
            fifo.corrected.eq(core.capture_position),
            fifo.flags.eq(core.flags),
            fifo.clear.eq(file.capture_clear),
            file.captures_cleared.eq(fifo.cleared),
            uart.enable.eq(file.capture_enable),
            compare.position.eq(core.position),
            compare.homed.eq(core.homed),
            compare.period.eq(file.compare_period),
            compare.start.eq(file.compare_start),
            compare.width.eq(file.compare_width),
            compare.restart.eq(file.grid_written),
            self.compare.eq(compare.pulse),
            recorder.raw_position.eq(core.raw_position),
            recorder.position.eq(core.position),
            recorder.time.eq(time),
            recorder.flags.eq(core.flags),
            recorder.homed.eq(core.homed),
            recorder.snapshot.eq(file.snapshot),
            file.snapshot_done.eq(recorder.snapshot_done),
            file.record_valid.eq(recorder.record_valid),
            file.record_place.eq(recorder.record_place),
            file.record.eq(recorder.record),
            trial.command.eq(file.trial),
            trial.index.eq(core.index),
            trial.address.eq(file.window_address),
            trial.write.eq(file.window_write),
            trial.word.eq(file.window_word),
            file.identity_word.eq(trial.identity_word),
            file.loading.eq(trial.loading),
            self.generator_control.eq(file.generator_control),
            self.generator_rate.eq(file.generator_rate),
        ]

        # Of a count that the register file keeps, it is told the lowest bits or, when events are rare, the lowest one.
        values = {
            "rom_crc32": trial.crc32,
            "rom_state": trial.state,
            "snapshot_number": recorder.snapshot_number,
            "flags": core.flags,
            "closure_error": core.closure_error,
            "largest_closure_error": core.largest_closure_error,
            "index_count": core.index_count[:TALLY_BITS],
            "shortest_edge_spacing": core.shortest_edge_spacing,
            "packets_refused": uart.packets_refused[0],
            "link_state": uart.requests_obeyed,
            "illegal_steps": core.illegal_steps,
            "compare_count": compare.count,
            "capture_level": fifo.level,
            "captures_lost": fifo.lost,
            "captures": fifo.captures,
        }
        for flag in fault_flags():
            counter = FaultCounter()
            m.submodules[f"{fault_key(flag)}_counter"] = counter
            m.d.comb += counter.cause.eq(core.causes[flag.bit_length() - 1])
            values[f"{fault_key(flag)}_count"] = counter.count
        m.d.comb += [getattr(file, name).eq(value) for name, value in values.items()]
        return m

    @staticmethod
    def _join_doors(m: Module, file: RegisterFile, uart: UartDoor, spi: SpiDoor) -> None:
        """One bus for two doors: who has it keeps it until it wants it no more; the UART goes first."""
        uart_has, spi_has = Signal(), Signal()
        m.d.sync += [
            uart_has.eq(uart.wants_bus & ~spi_has),
            spi_has.eq(spi.wants_bus & ~uart_has & (spi_has | ~uart.wants_bus)),
        ]
        bus = file.bus
        m.d.comb += [uart.has_bus.eq(uart_has & uart.wants_bus), spi.has_bus.eq(spi_has & spi.wants_bus)]
        for name in ("valid", "request", "address", "following", "is_last", "write_word"):
            m.d.comb += getattr(bus, name).eq(Mux(spi_has, getattr(spi.bus, name), getattr(uart.bus, name)))
        # The answer comes a clock later, so that the doors' own thoughts do not follow on the registers'.
        read_word, status = Signal.like(bus.read_word), Signal.like(bus.status)
        m.d.sync += [read_word.eq(bus.read_word), status.eq(bus.status)]
        for door, has in ((uart, uart_has), (spi, spi_has)):
            m.d.sync += door.bus.done.eq(bus.done & has)
            m.d.comb += [door.bus.read_word.eq(read_word), door.bus.status.eq(status)]
