"""`arcref zero-return`: the zero-return test on an instrument, with the shaft turning or the test generator."""

from pathlib import Path

import click
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn

from arcref.instrument.connection import with_encoder
from arcref.instrument.encoder import Encoder
from arcref.instrument.hardware_zero_return import MOST_REVOLUTIONS, READINGS_PER_S, hardware_zero_return
from arcref.instrument.zero_return_leg import ZeroReturnProgress
from arcref.link.registers import GENERATOR_FAULTS
from arcref.output_files import check_outputs
from arcref.rom_image import load_rom
from arcref.zero_return.outputs import print_result, write_outputs
from arcref.zero_return.result import ZeroReturnResult

FILE = click.Path(path_type=Path)


@click.command("zero-return")
@with_encoder
@click.option(
    "--revolutions",
    type=click.IntRange(0, MOST_REVOLUTIONS),
    default=10,
    show_default=True,
    help="Full turns each way.",
)
@click.option(
    "--generator",
    "generator_speed_rps",
    type=float,
    metavar="RPS",
    help="Let the on-board test generator turn, at this speed, instead of the shaft.",
)
@click.option(
    "--generator-fault",
    type=click.Choice(list(GENERATOR_FAULTS)),
    help="A fault for the test generator to make: the test must FAIL.",
)
@click.option("--rehome", is_flag=True, help="Let the first zero mark set the zero again.")
@click.option("--rom", "rom_path", type=FILE, metavar="X.rom.json", help="Compare every reading with this ROM image.")
@click.option(
    "--timeout",
    "timeout_s",
    type=click.FloatRange(min=0, min_open=True),
    default=60.0,
    show_default=True,
    metavar="S",
    help="Longest wait for the shaft to turn.",
)
@click.option(
    "--rate",
    "readings_per_s",
    type=click.FloatRange(0, 1000, min_open=True),
    default=READINGS_PER_S,
    show_default=True,
    metavar="HZ",
    help="Readings a second.",
)
@click.option("--json", "json_path", type=FILE, metavar="FILE", help="Write the result as JSON, too.")
@click.option("--page", type=FILE, metavar="FILE.html", help="Write the page with the plots.")
def zero_return(encoder, rom_path, json_path, page, **options):
    """Turn forward and back, and see every zero mark return to its count.

    Turn the shaft by hand or with its motor as the lines say, or name a speed for the on-board test generator; in a
    self-test bitstream it turns from power-up, and nothing need be named. Fault flags are cleared at the start; the
    zero stays where it is unless --rehome is given. Ends with PASS (status 0) or FAIL (status 1).
    """
    check_outputs([json_path, page], [rom_path] if rom_path else [])
    rom = load_rom(rom_path) if rom_path else None
    result = _run_with_bar(encoder, rom=rom, **options)
    write_outputs(result, page, json_path)
    print_result(result, page)
    if not result.passed:
        raise click.exceptions.Exit(1)


def _run_with_bar(encoder: Encoder, **options) -> ZeroReturnResult:
    """Run it with a bar on stderr that says where it is; what the user must do is printed above."""
    console = Console(stderr=True, highlight=False)
    with Progress(
        TextColumn("{task.description}"), BarColumn(), console=console, transient=True, disable=not console.is_terminal
    ) as bar:
        task = bar.add_task("looking", total=1.0)

        def show(state: ZeroReturnProgress) -> None:
            where = f"{state.leg}, {state.turns_done:.2f} of {state.turns} turns, {state.speed_rps:+.3f} r/s"
            bar.update(task, description=where, completed=state.part)

        def ask(line: str) -> None:
            console.print(line, soft_wrap=True, markup=False)

        return hardware_zero_return(encoder, progress=show, ask=ask, **options)
