"""`arcref capture`: strobed angles into a file, as they arrive."""

from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import click
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from arcref import __version__
from arcref.instrument.capture_file import open_capture_file
from arcref.instrument.captures import UNKNOWN_LOSS, capture_array
from arcref.instrument.connection import SECONDS, with_encoder
from arcref.instrument.encoder import RECONNECT_S, Encoder
from arcref.instrument.recorded_captures import UNCERTAINTY_KEY
from arcref.instrument.uninterrupted import uninterrupted

BATCH_RECORDS = 4096
"""Captures that are put on the disk together, at the most. They are put there as soon as no other one waits."""


@click.command()
@with_encoder
@click.option("-n", "--number", type=click.IntRange(min=1), required=True, help="Captures to take.")
@click.option("-o", "--output", type=click.Path(path_type=Path), required=True, metavar="FILE.csv|FILE.h5")
@click.option(
    "--timeout", "timeout_s", type=SECONDS, default=10.0, show_default=True, metavar="S", help="Longest pause."
)
@click.option(
    "--reconnect",
    "reconnect_s",
    type=SECONDS,
    default=RECONNECT_S,
    show_default=True,
    metavar="S",
    help="How long to wait for a cable that was pulled.",
)
def capture(encoder, number, output, timeout_s, reconnect_s):
    """Capture the angle at each strobe, and write every capture as it arrives.

    Ends after so many captures, or on Ctrl-C; what came until then stands in the file.
    """
    encoder.reconnect_s = reconnect_s
    file = open_capture_file(output, capture_provenance(encoder))
    losses = Losses()
    try:
        try:
            _capture(encoder, number, timeout_s, file, losses)
        finally:
            file.close()
    except BaseException:
        if file.captures:
            click.echo(f"{output}: {file.captures} of {number} captures", err=True)
        raise
    finally:
        if losses:
            click.echo(f"captures lost: {losses}; the column lost_before says where", err=True)
    click.echo(f"{output}: {file.captures} captures")


@dataclass
class Losses:
    """Captures that were lost: `known` of them, and in `gaps` gaps nobody knows how many."""

    known: int = 0
    gaps: int = 0

    def add(self, lost_before: int) -> None:
        """Take the losses before one capture."""
        if lost_before == UNKNOWN_LOSS:
            self.gaps += 1
        else:
            self.known += lost_before

    def __bool__(self):
        return bool(self.known or self.gaps)

    def __str__(self):
        unknown = f", and {self.gaps} gap{'s' * (self.gaps != 1)} of unknown length" if self.gaps else ""
        return f"{self.known}{unknown}"


def capture_provenance(encoder: Encoder) -> dict:
    """What a capture file says about where it comes from."""
    identity = encoder.identity
    calibration = identity.rom.values if identity.rom else {}
    return {
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
        "encoder_serial": calibration.get("serial", "unknown"),
        "rom_crc32": f"0x{identity.rom_crc32:08X}",
        "rom_state": identity.rom_state + (", trial" if identity.rom_is_trial else ""),
        UNCERTAINTY_KEY: calibration.get("expanded uncertainty", "unknown"),
        "sample_rate_hz": f"{identity.sample_rate_hz:.0f}",
        "strobe_delay_samples": encoder.registers.strobe_delay,
        "gateware": identity.gateware,
        "arcref": __version__,
    }


def _capture(encoder: Encoder, number: int, timeout_s: float, file, losses: Losses) -> None:
    """Take `number` captures into `file`."""
    batch, taken = [], 0
    rate_hz = encoder.identity.sample_rate_hz
    console = Console(stderr=True)
    columns = (TextColumn("captures"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task("", total=number)
        stream = encoder.stream(timeout_s)
        try:
            for before, record in stream:
                with uninterrupted():
                    batch.append((before, record))
                    losses.add(before)
                    taken += 1
                    if taken == number:
                        break
                    if len(batch) >= BATCH_RECORDS or not encoder.captures_waiting:
                        full, batch = batch, []
                        file.append(capture_array(full, rate_hz))
                        bar.update(task, completed=taken)
        finally:
            try:
                stream.close()
            finally:
                if batch:
                    file.append(capture_array(batch, rate_hz))
