"""`arcref capture`: strobed angles into a file, as they arrive."""

from datetime import UTC, datetime
from pathlib import Path

import click
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from arcref import __version__
from arcref.instrument.capture_file import open_capture_file
from arcref.instrument.captures import capture_array
from arcref.instrument.connection import with_encoder
from arcref.instrument.encoder import Encoder
from arcref.instrument_error import InstrumentError

BATCH_RECORDS = 4096
"""Captures that are put on the disk together, at the most. They are put there as soon as no other one waits."""


@click.command()
@with_encoder
@click.option("-n", "--number", type=click.IntRange(min=1), required=True, help="Captures to take.")
@click.option("-o", "--output", type=click.Path(path_type=Path), required=True, metavar="FILE.csv|FILE.h5")
@click.option("--timeout", "timeout_s", type=float, default=10.0, show_default=True, metavar="S", help="Longest pause.")
@click.option(
    "--reconnect",
    "reconnect_s",
    type=float,
    default=30.0,
    show_default=True,
    metavar="S",
    help="How long to wait for a cable that was pulled.",
)
def capture(encoder, number, output, timeout_s, reconnect_s):
    """Capture the angle at each strobe, and write every capture as it arrives."""
    encoder.reconnect_s = reconnect_s
    file = open_capture_file(output, capture_provenance(encoder))
    try:
        taken, lost, gaps = _capture(encoder, number, timeout_s, file)
    finally:
        file.close()
    click.echo(f"{output}: {taken} captures")
    if lost or gaps:
        unknown = f", and {gaps} gap{'s' * (gaps != 1)} of unknown length" if gaps else ""
        click.echo(f"captures lost: {lost}{unknown}; the column lost_before says where", err=True)


def capture_provenance(encoder: Encoder) -> dict:
    """What a capture file says about where it comes from."""
    identity = encoder.identity
    calibration = identity.rom.values if identity.rom else {}
    return {
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
        "encoder_serial": calibration.get("serial", "unknown"),
        "rom_crc32": f"0x{identity.rom_crc32:08X}",
        "rom_state": identity.rom_state + (", trial" if identity.rom_is_trial else ""),
        "calibration_expanded_uncertainty": calibration.get("expanded uncertainty", "unknown"),
        "sample_rate_hz": f"{identity.sample_rate_hz:.0f}",
        "strobe_delay_samples": encoder.registers.strobe_delay,
        "gateware": identity.gateware,
        "arcref": __version__,
    }


def _capture(encoder: Encoder, number: int, timeout_s: float, file) -> tuple[int, int, int]:
    """Take `number` captures into `file`; how many came, were lost, and how many gaps of unknown length there were."""
    batch, taken, lost, gaps = [], 0, 0, 0
    rate_hz = encoder.identity.sample_rate_hz
    columns = (TextColumn("captures"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("", total=number)
        stream = encoder.stream(timeout_s)
        try:
            for before, record in stream:
                batch.append((before, record))
                taken += 1
                lost, gaps = lost + max(before, 0), gaps + (before < 0)
                if taken == number:
                    break
                if len(batch) >= BATCH_RECORDS or not encoder.captures_waiting:
                    _write(file, batch, rate_hz)
                    batch = []
                    bar.update(task, completed=taken)
        finally:
            stream.close()
            _write(file, batch, rate_hz)
    return taken, lost, gaps


def _write(file, batch: list, rate_hz: float) -> None:
    if not batch:
        return
    try:
        file.append(capture_array(batch, rate_hz))
    except OSError as error:
        raise InstrumentError(
            f"{len(batch)} captures could not be written ({error.strerror}); what was written before is whole"
        ) from error
