"""`arcref watch`: the angle, the speed and the faults as they are now, until Ctrl-C."""

import time
from contextlib import nullcontext

import click
from rich.console import Console
from rich.live import Live
from rich.table import Table
from rich.text import Text

from arcref.angle import COUNTS_PER_TURN
from arcref.flags import FLAG_MEANINGS, Flag, describe_faults
from arcref.instrument.connection import SECONDS, with_encoder
from arcref.instrument.encoder import Encoder
from arcref.instrument.read_command import ANGLE_FORMATS, format_angle
from arcref.instrument.snapshot import Snapshot

REFRESHES_PER_S = 10


@click.command()
@with_encoder
@click.option(
    "--format", "form", type=click.Choice(ANGLE_FORMATS), default="dms", show_default=True, help="Of the angle."
)
@click.option("--seconds", type=SECONDS, metavar="S", help="End by itself after this time.")
def watch(encoder, form, seconds):
    """Show angle, speed and faults until Ctrl-C."""
    end = None if seconds is None else time.monotonic() + seconds
    console = Console(highlight=False)
    before = encoder.snapshot()
    # In a file or a pipe each reading is a line; on a screen they replace one another.
    with Live(console=console, refresh_per_second=REFRESHES_PER_S) if console.is_terminal else nullcontext() as live:
        while end is None or time.monotonic() < end:
            time.sleep(1 / REFRESHES_PER_S)
            now = encoder.snapshot()
            if live:
                live.update(_view(encoder, before, now, form))
            else:
                click.echo(_line(before, now, form))
            before = now


@click.command(params=list(watch.params))
def monitor(**options):
    """The same as watch."""
    watch.callback(**options)


def speed_rps(before: Snapshot, now: Snapshot) -> float | None:
    """Mean speed between two snapshots, by the instrument's own clock; None when they are of one instant."""
    elapsed_s = now.time_s - before.time_s
    return (now.raw_position - before.raw_position) / COUNTS_PER_TURN / elapsed_s if elapsed_s > 0 else None


def _speed_text(before: Snapshot, now: Snapshot) -> str:
    speed = speed_rps(before, now)
    return "-" if speed is None else f"{speed:+.4f} r/s"


def _line(before: Snapshot, now: Snapshot, form: str) -> str:
    state = "not homed" if not now.homed else "corrected" if now.flags & Flag.CORRECTION_ACTIVE else "not corrected"
    faults = ", ".join(describe_faults(now.flags)) or "none"
    return f"{now.time_s:.6f} s  {format_angle(now, form)}  {_speed_text(before, now)}  {state}  faults: {faults}"


def _view(encoder: Encoder, before: Snapshot, now: Snapshot, form: str) -> Table:
    registers = encoder.registers
    table = Table(show_header=False, box=None, pad_edge=False)
    table.add_row("angle", Text(format_angle(now, form), "bold"))
    table.add_row("speed", _speed_text(before, now))
    table.add_row("homed", "yes" if now.homed else "no: turn past the zero mark once")
    table.add_row("corrected", "yes" if now.flags & Flag.CORRECTION_ACTIVE else "no")
    table.add_row("closure error", f"{registers.closure_error} counts, largest {registers.largest_closure_error}")
    table.add_row("shortest edge spacing", f"{registers.shortest_edge_spacing} samples")
    faults = describe_faults(now.flags)
    table.add_row("faults", Text(", ".join(faults), "red") if faults else Text("none", "green"))
    for flag, meaning in FLAG_MEANINGS.items():
        if meaning.name in faults and now.flags & flag:
            table.add_row("", Text(meaning.action))
    return table
