"""`arcref info`: who the instrument is, and the calibration it carries."""

import dataclasses
import json

import click
from rich.console import Console
from rich.table import Table
from rich.text import Text

from arcref.atomic_file import write_text
from arcref.flags import describe_faults
from arcref.instrument.connection import JSON_FILE, with_encoder
from arcref.instrument.identity import Identity


@click.command()
@with_encoder
@click.option("--json", "json_path", type=JSON_FILE, metavar="FILE", help="Write it as JSON, too.")
def info(encoder, json_path):
    """Say which instrument is plugged in, and which calibration it carries."""
    identity, faults = encoder.identity, describe_faults(encoder.flags)
    if json_path:
        content = dataclasses.asdict(identity) | {
            "sample_rate_hz": identity.sample_rate_hz,
            "calibration": identity.rom.values if identity.rom else None,
            "faults": faults,
            "port": encoder.port,
        }
        write_text(json_path, json.dumps(content, indent=2) + "\n")
    table = Table(show_header=False, box=None, pad_edge=False)
    for name, value in _lines(encoder.port, identity, faults):
        table.add_row(name, Text(value))
    Console(highlight=False).print(table)


def _lines(port: str, identity: Identity, faults: list[str]):
    yield "port", port
    yield "gateware", f"{identity.gateware}, protocol {identity.protocol}"
    yield (
        "samples",
        (
            f"{identity.sample_rate_hz / 1e6:g} M samples/s, {identity.samples_per_word} a word at "
            f"{identity.word_clock_hz / 1e6:g} MHz"
        ),
    )
    yield "captures", f"a FIFO of {identity.capture_depth} records"
    yield "test generator", "there" if identity.has_test_generator else "not in this bitstream"
    trial = ", a trial that is gone at power-off" if identity.rom_is_trial else ""
    yield "correction ROM", f"{identity.rom_state}, CRC-32 0x{identity.rom_crc32:08X}{trial}"
    if identity.rom is None:
        yield "calibration", f"cannot be read: {identity.rom_problem}"
    else:
        for key, value in identity.rom.values.items():
            yield f"  {key}", value
    yield "fault flags up", ", ".join(faults) or "none"
