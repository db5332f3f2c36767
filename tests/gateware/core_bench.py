"""The whole core in Amaranth's simulator, and the comparison with its golden model."""

import numpy as np
from amaranth_bench import Bench, as_bits

from arcref_gateware.golden.core import CAPTURE, POSITION_CHANGE, STATUS_CHANGE, CoreOutput
from arcref_gateware.golden.signal_changes import A_BIT, B_BIT, STROBE_BIT, Z_BIT, SignalChanges
from arcref_gateware.latency import LATENCY_CLOCKS
from arcref_gateware.reference_encoder import ReferenceEncoder

LINES = {"a": A_BIT, "b": B_BIT, "z": Z_BIT, "strobe": STROBE_BIT}
CONTROLS = ["strobe_delay", "spi_sck", "spi_cs_n", "spi_copi", "rst"]
OUTPUTS = [
    *POSITION_CHANGE.names[1:],
    *STATUS_CHANGE.names[1:],
    "capture_valid",
    *CAPTURE.names[1:],
    "shortest_edge_spacing",
    "largest_closure_error",
    "first_illegal_position",
    "first_illegal_time",
    "spi_cipo",
]


class CoreBench:
    """One core, run over pieces of input that start at sample 0."""

    def __init__(self, rom, samples_per_word: int, **parameters):
        self.samples_per_word = samples_per_word
        core = ReferenceEncoder(rom, samples_per_word, **parameters)
        self.bench = Bench(core, [*LINES, *CONTROLS], OUTPUTS)

    def run(self, piece: SignalChanges, **controls) -> dict[str, np.ndarray]:
        """What each output shows for every word of `piece`: row k is the state after word k.

        `controls` drive the other inputs, an entry a word clock from the first word on.
        """
        words = piece.to_words(self.samples_per_word)
        lines = {name: as_bits(words >> bit & 1) for name, bit in LINES.items()}
        clocks = len(words) + LATENCY_CLOCKS
        rows = self.bench.run(clocks, **lines, **controls)
        for name in OUTPUTS[:-1]:
            if name != "shortest_edge_spacing":
                assert not rows[name][:LATENCY_CLOCKS].any(), f"{name} is not 0 before the first word"
        return {name: column[LATENCY_CLOCKS:] for name, column in rows.items()}


def as_output(rows: dict[str, np.ndarray]) -> CoreOutput:
    """The rows of a core as lists of changes, as the golden model gives them."""
    captured = np.flatnonzero(rows["capture_valid"])
    captures = np.empty(len(captured), CAPTURE)
    captures["word"] = captured
    for name in CAPTURE.names[1:]:
        captures[name] = rows[name][captured]
    return CoreOutput(_changes(rows, POSITION_CHANGE), _changes(rows, STATUS_CHANGE), captures)


def _changes(rows, dtype) -> np.ndarray:
    names = dtype.names[1:]
    changed = np.any([np.diff(rows[name], prepend=0) != 0 for name in names], axis=0)
    word = np.flatnonzero(changed)
    changes = np.empty(len(word), dtype)
    changes["word"] = word
    for name in names:
        changes[name] = rows[name][word]
    return changes


def assert_same_output(got: CoreOutput, expected: CoreOutput) -> None:
    """Fail with the first change that the core and the golden model do not share, fields by name."""
    for part in ("positions", "status", "captures"):
        core, model = getattr(got, part), getattr(expected, part)
        common = min(len(core), len(model))
        differs = np.flatnonzero(core[:common] != model[:common])
        if len(differs) == 0 and len(core) == len(model):
            continue
        at = int(differs[0]) if len(differs) else common
        report = [f"{part}: {len(core)} changes from the core, {len(model)} from the model, first difference at {at}"]
        for number in range(max(at - 1, 0), at + 2):
            for who, changes in (("core ", core), ("model", model)):
                if number < len(changes):
                    fields = ", ".join(f"{name} {changes[name][number]}" for name in changes.dtype.names)
                    report.append(f"  {number} {who} {fields}")
        raise AssertionError("\n".join(report))
