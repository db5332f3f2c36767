"""What `arcref build` prints at its end, from the record of a build."""

from collections.abc import Iterable
from pathlib import Path


def printed(record: dict, files: Iterable[Path]) -> str:
    """What a person reads at the end: the figures of a record, and the files that were written."""
    lines = [*figures(record), *(("written" if place == 0 else "", str(path)) for place, path in enumerate(files))]
    width = max(len(name) for name, _ in lines)
    return "".join(f"{name:{width}}  {value}\n" for name, value in lines)


def figures(record: dict):
    """The lines that a person reads of a record: name and value."""
    clocked = record["as_clocked"]
    yield "board", f"{record['title']}, {record['device']} {record['package']}"
    yield (
        "word clock",
        (f"{record['word_clock_hz'] / 1e6:g} MHz wanted, {record['word_clock_reached_hz'] / 1e6:.1f} MHz reached"),
    )
    yield "samples", f"{record['samples_per_word']} a word, {clocked['samples_per_s'] / 1e6:g} M samples/s as clocked"
    yield (
        "highest speed",
        (
            f"{clocked['highest_speed_1_samples_per_count_rps']:.1f} r/s at 1 sample a count, "
            f"{clocked['highest_speed_1_5_samples_per_count_rps']:.1f} r/s at 1.5"
        ),
    )
    yield "cells", f"{record['cells']} of {record['cells_available']}"
    yield "block RAMs", f"{record['block_rams']} of {record['block_rams_available']}"
    yield (
        "serial link",
        (
            f"UART at {record['baud'] / 1e6:g} Mbaud, {record['capture_depth']} captures"
            if record["has_link"]
            else "none, SPI alone"
        ),
    )
    tried = len(record["seeds_tried"])
    yield "seed", f"{record['seed']}, {tried} tried" if tried > 1 else f"{record['seed']}, the first tried"
    if record["self_test"]:
        yield "self-test", f"{record['self_test']['speed_rps']:g} r/s, fault: {record['self_test']['fault'] or 'none'}"
    yield "ROM", f"0x{record['rom_crc32']:08X}, every word unpacked and compared"
