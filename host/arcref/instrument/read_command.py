"""`arcref read`: the angle, once."""

import json

import click

from arcref.angle import COUNTS_PER_TURN, format_dms
from arcref.atomic_file import write_text
from arcref.flags import Flag, describe_faults
from arcref.instrument.connection import JSON_FILE, with_encoder
from arcref.instrument.snapshot import Snapshot

ANGLE_FORMATS = ("dms", "deg", "counts")


def format_angle(snapshot: Snapshot, form: str) -> str:
    """The angle of a snapshot as degrees, minutes and seconds, as degrees, or in counts with the turns."""
    if form == "counts":
        return f"{snapshot.position} counts"
    angle = format_dms(snapshot.angle_deg) if form == "dms" else f"{snapshot.angle_deg:.7f} deg"
    return f"{angle}, turn {snapshot.turns}"


def snapshot_json(snapshot: Snapshot) -> dict:
    """A snapshot as plain values with their units in the names."""
    return {
        "angle_deg": snapshot.angle_deg,
        "position_counts": snapshot.position,
        "raw_position_counts": snapshot.raw_position,
        "turns": snapshot.turns,
        "counts_per_turn": COUNTS_PER_TURN,
        "time_s": snapshot.time_s,
        "homed": snapshot.homed,
        "corrected": bool(snapshot.flags & Flag.CORRECTION_ACTIVE),
        "faults": describe_faults(snapshot.flags),
    }


@click.command()
@with_encoder
@click.option(
    "--format", "form", type=click.Choice(ANGLE_FORMATS), default="dms", show_default=True, help="Of the angle."
)
@click.option(
    "--json",
    "json_path",
    type=JSON_FILE,
    metavar="FILE",
    help="Write it as JSON, too, with raw position, time and flags.",
)
def read(encoder, form, json_path):
    """Read the angle once."""
    snapshot = encoder.snapshot()
    if json_path:
        write_text(json_path, json.dumps(snapshot_json(snapshot), indent=2) + "\n")
    click.echo(format_angle(snapshot, form))
    if not snapshot.homed:
        click.echo("not homed: turn past the zero mark once; until then the angle counts from power-up", err=True)
    elif not snapshot.flags & Flag.CORRECTION_ACTIVE:
        click.echo("not corrected", err=True)
    for fault in describe_faults(snapshot.flags):
        click.echo(f"fault: {fault}", err=True)
