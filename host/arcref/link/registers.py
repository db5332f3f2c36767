"""The registers of the instrument, declared once: gateware, host and manual are made from this list.

Reading changes nothing and clears nothing, with one exception that is meant: reading the word `snapshot_number`
latches a new snapshot, of which the words behind it are parts. A read of several words is never split, so
one request brings position, raw position, time and flags of one instant.
"""

from arcref.angle import LINES_PER_TURN, POSITION_BITS
from arcref.correction_rom import SUBDIVISION_ENTRIES
from arcref.flags import FAULT_FLAGS, FLAG_MEANINGS
from arcref.link.register import Access, Field, Register, RegisterMap, Window
from arcref.rom_identity import IDENTITY_WORDS

MAGIC = 0x4152
"""First word of every instrument, "AR"."""

PROTOCOL_VERSION = 1
GATEWARE_VERSION = 0x0100
"""Version of the gateware: high byte major, low byte minor."""

STROBE_SOURCES = ("pin", "timer", "chip select", "command")
STROBE_EDGES = ("rising", "falling", "both")
ROM_STATES = ("checking", "good", "fault", "loading", "waiting for the index")

GENERATOR_FAULTS = {
    "dropped_edge": "A stays low for one period of it in each turn forward: four counts lost without an illegal step.",
    "doubled_step": "Two counts at once in each turn forward: an illegal step.",
    "missing_index": "No zero pulse comes in reverse.",
    "wide_index": "The zero pulse is two periods of A wide, so the zero mark comes twice, four counts apart.",
}
"""Faults that the test generator can make, in the order of their bits from 2 on."""

GENERATOR_RATE_STEP = 256
"""The generator's rate is a multiple of this; the bits below are not used."""

FAULT_LOG_ADDRESS = 0x0040
FAULT_LOG_STRIDE = 8


def fault_key(flag) -> str:
    """How the registers of a fault flag begin: `illegal_step` for instance."""
    return flag.name.lower()


def _fault_log() -> tuple[Register, ...]:
    registers = []
    for place, (flag, meaning) in enumerate((f, m) for f, m in FLAG_MEANINGS.items() if f & FAULT_FLAGS):
        key, first = fault_key(flag), FAULT_LOG_ADDRESS + FAULT_LOG_STRIDE * place
        when = f"when the flag {meaning.name!r} last went up"
        registers += [
            Register(
                f"{key}_first_position",
                first,
                POSITION_BITS,
                Access.READ,
                f"Raw position {when}.",
                "counts",
                signed=True,
            ),
            Register(
                f"{key}_first_time",
                first + 3,
                POSITION_BITS,
                Access.READ,
                f"Time {when}.",
                "sample periods",
            ),
            Register(
                f"{key}_count",
                first + 6,
                16,
                Access.READ,
                f"Sample words with the cause of {meaning.name!r} since reset; stays at 65535.",
            ),
        ]
    return tuple(registers)


REGISTERS = RegisterMap(
    (
        # What is this?
        Register("magic", 0x0000, 16, Access.READ, 'Always 0x4152, "AR".', reset=MAGIC),
        Register("protocol", 0x0001, 16, Access.READ, "Version of registers and packets.", reset=PROTOCOL_VERSION),
        Register("gateware", 0x0002, 16, Access.READ, "Version of the gateware.", reset=GATEWARE_VERSION),
        Register("samples_per_word", 0x0003, 16, Access.READ, "Samples in a word.", "samples"),
        Register("word_clock_hz", 0x0004, 32, Access.READ, "Frequency of the word clock.", "Hz"),
        Register("capture_depth", 0x0006, 16, Access.READ, "Records that the capture FIFO holds.", "records"),
        Register(
            "features",
            0x0007,
            16,
            Access.READ,
            "What this gateware has beside the core.",
            fields=(Field("test_generator", 0, 1, "The test generator is there."),),
        ),
        Register("rom_crc32", 0x0008, 32, Access.READ, "CRC-32 of the correction tables, as their identity states it."),
        Register(
            "rom_state",
            0x000A,
            16,
            Access.READ,
            "State of the correction ROM.",
            fields=(
                Field("state", 0, 3, "What the ROM is at.", ROM_STATES),
                Field("trial", 3, 1, "The tables were loaded over the link and are gone at power-off."),
            ),
        ),
        # One instant.
        Register("snapshot_number", 0x0010, 16, Access.READ, "Number of the snapshot; reading it takes a new one."),
        Register("snapshot_raw", 0x0011, 48, Access.READ, "Raw position of the snapshot.", "counts", signed=True),
        Register("snapshot_time", 0x0014, 48, Access.READ, "Time of the snapshot, since reset.", "sample periods"),
        Register(
            "snapshot_position", 0x0017, 48, Access.READ, "Corrected position of the snapshot.", "counts", signed=True
        ),
        Register(
            "snapshot_flags",
            0x001A,
            16,
            Access.READ,
            "Flags of the snapshot.",
            fields=(
                Field("flags", 0, 8, "The flag byte, see the table of flags."),
                Field("homed", 8, 1, "1 once the zero mark was met."),
            ),
        ),
        # What watches.
        Register("flags", 0x0020, 16, Access.READ, "The flag byte now."),
        Register("clear_flags", 0x0021, 8, Access.COMMAND, "Clears the fault flags whose bits are 1."),
        Register("closure_error", 0x0022, 24, Access.READ, "Closure error at the last index.", "counts", signed=True),
        Register(
            "largest_closure_error",
            0x0024,
            24,
            Access.READ,
            "The closure error largest in size, with its sign.",
            "counts",
            signed=True,
        ),
        Register("index_count", 0x0026, 16, Access.READ, "Indices since reset, modulo 65536."),
        Register("shortest_edge_spacing", 0x0027, 12, Access.READ, "Shortest spacing of two edges.", "sample periods"),
        Register(
            "packets_refused",
            0x0028,
            16,
            Access.READ,
            "Packets over the UART that were refused, modulo 65536: broken, or a third while two were on their way.",
        ),
        Register("link_state", 0x0029, 16, Access.READ, "Requests that were obeyed over the UART, modulo 65536."),
        Register("illegal_steps", 0x002A, 16, Access.READ, "Samples in which A and B both changed; stays at 65535."),
        *_fault_log(),
        # Settings of the count.
        Register(
            "gate_state",
            0x0080,
            2,
            Access.WRITE,
            "State of A and B in which a high Z is the zero mark.",
            reset=0b11,
            fields=(Field("a", 0, 1, "Level of A."), Field("b", 1, 1, "Level of B.")),
        ),
        Register("home", 0x0081, 1, Access.COMMAND, "1: the next index sets the zero again."),
        Register("correction_enable", 0x0082, 1, Access.WRITE, "1: positions are corrected from the ROM.", reset=1),
        # Strobe.
        Register("strobe_delay", 0x0084, 16, Access.WRITE, "From a strobe to its due sample.", "sample periods"),
        Register(
            "strobe_control",
            0x0085,
            4,
            Access.WRITE,
            "Where strobes come from.",
            fields=(
                Field("source", 0, 2, "What captures.", STROBE_SOURCES),
                Field("edge", 2, 2, "Which edge of the pin, or of chip select.", STROBE_EDGES),
            ),
        ),
        Register("strobe_period", 0x0086, 32, Access.WRITE, "Period of the timer; 0 and 1 stop it.", "word clocks"),
        Register("strobe_command", 0x0088, 1, Access.COMMAND, "1: one strobe now, when the source is the command."),
        # Compare output.
        Register(
            "compare_period",
            0x0090,
            24,
            Access.WRITE,
            "Counts of corrected position from pulse to pulse, 64 or more; below that the output is off.",
            "counts",
        ),
        Register("compare_start", 0x0092, 23, Access.WRITE, "Corrected angle that has a pulse.", "counts"),
        Register("compare_width", 0x0094, 16, Access.WRITE, "Length of a pulse.", "word clocks", reset=1),
        Register("compare_count", 0x0096, 32, Access.READ, "Pulses given since reset."),
        # Captures.
        Register("capture_enable", 0x00A0, 1, Access.WRITE, "1: records are streamed over the UART as they come."),
        Register("capture_clear", 0x00A1, 1, Access.COMMAND, "1: empties the FIFO, and its counts start from 0."),
        Register("capture_level", 0x00A2, 16, Access.READ, "Records in the FIFO.", "records"),
        Register("captures_lost", 0x00A4, 32, Access.READ, "Captures that found the FIFO full, since it was emptied."),
        Register("captures", 0x00A6, 32, Access.READ, "Captures since the FIFO was emptied, lost ones too."),
        # Test generator, where the gateware has one.
        Register(
            "generator_control",
            0x00B0,
            2 + len(GENERATOR_FAULTS),
            Access.WRITE,
            "Control of the test generator.",
            fields=(
                Field("run", 0, 1, "1: it turns, and its A, B, Z and strobe are counted in place of the encoder's."),
                Field("reverse", 1, 1, "1: it turns in reverse."),
                *(Field(name, 2 + i, 1, meaning) for i, (name, meaning) in enumerate(GENERATOR_FAULTS.items())),
            ),
        ),
        Register(
            "generator_rate",
            0x00B2,
            32,
            Access.WRITE,
            f"Counts in a sample period; the lowest {GENERATOR_RATE_STEP.bit_length() - 1} bits are not used.",
            "counts/2^32",
        ),
        # Trial tables.
        Register(
            "trial",
            0x00C0,
            2,
            Access.COMMAND,
            "Loading of trial tables.",
            fields=(
                Field("begin", 0, 1, "1: the correction goes off and the table windows may be written."),
                Field("finish", 1, 1, "1: the tables are checked; if good they are in force at the next index."),
            ),
        ),
    ),
    (
        Window("identity", 0x0200, IDENTITY_WORDS, Access.WRITE, "The identity memory; written while loading only."),
        Window(
            "subdivision_table", 0x0400, SUBDIVISION_ENTRIES, Access.COMMAND, "Written while loading; reads unknown."
        ),
        Window("line_table", 0x1000, LINES_PER_TURN, Access.COMMAND, "Written while loading; reads unknown."),
    ),
)
