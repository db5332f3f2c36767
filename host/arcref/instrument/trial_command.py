"""`arcref trial`: another correction, tried in the running instrument before it is flashed."""

from pathlib import Path

import click
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn

from arcref.instrument.connection import with_encoder
from arcref.rom_image import load_rom


@click.command()
@with_encoder
@click.argument("rom_path", type=click.Path(path_type=Path), metavar="X.rom.json")
@click.option("--any-encoder", is_flag=True, help="Load it though it is the ROM of another encoder.")
def trial(encoder, rom_path, any_encoder):
    """Try a ROM image in the running instrument, until power-off.

    The instrument verifies it by its CRC. It is in force from the next zero mark on.
    """
    rom = load_rom(rom_path)
    console = Console(stderr=True)
    columns = (TextColumn("loading"), BarColumn())
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task("", total=1.0)
        encoder.load_trial(rom, lambda part: bar.update(task, completed=part), any_encoder=any_encoder)
    click.echo(f"{rom_path}: CRC-32 0x{rom.crc32:08X} verified by the instrument")
    click.echo("In force from the next zero mark on: turn past it. Gone at power-off.")
