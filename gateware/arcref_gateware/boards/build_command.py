"""`arcref build`: from a board and a ROM to a bitstream whose timing holds, and its record."""

import dataclasses
from pathlib import Path

import click
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

from arcref import __version__
from arcref.atomic_file import write_files
from arcref.correction_rom import CorrectionRom
from arcref.input_error import InputError
from arcref.link.registers import GENERATOR_FAULTS
from arcref.rom_image import load_rom
from arcref_gateware.boards.bitstream_tables import (
    BITSTREAMS,
    TablesDiffer,
    locate_tables,
    replace_tables,
)
from arcref_gateware.boards.board import Board
from arcref_gateware.boards.board_file import BOARD_FOLDER, load_board
from arcref_gateware.boards.board_top import BoardTop
from arcref_gateware.boards.build_figures import printed
from arcref_gateware.boards.build_record import (
    DEFAULT_BUILD_FOLDER,
    FORMAT,
    RECORD_NAME,
    VERSION,
    record_json,
    speed_figures,
    with_rom,
)
from arcref_gateware.boards.place_and_route import (
    DESIGN,
    SUFFIX,
    TOOLS,
    PlacedDesign,
    TimingFailed,
    place_and_route,
)
from arcref_gateware.boards.self_test import SelfTest
from arcref_gateware.boards.table_layout import TablesNotFound
from arcref_gateware.strobe_delay import STROBE_DELAY_BITS
from arcref_gateware.table_contents import rom_contents
from arcref_gateware.toolchain import ToolError, tool_versions

FILE = click.Path(path_type=Path)

LOG_NAME = "place_and_route.log"


class SeedList(click.ParamType):
    """Seeds as `1,2,5` or `1-16`."""

    name = "seeds"

    def convert(self, value, param, ctx):
        """The seeds as a tuple of integers, in the order given."""
        seeds = []
        for part in value.split(","):
            first, dash, last = part.strip().partition("-")
            if not first.isdigit() or (dash and not last.isdigit()):
                self.fail(f"{value!r}: whole numbers from 1 were expected, as 1,2,5 or 1-16", param, ctx)
            seeds += range(int(first), int(last or first) + 1)
        if not seeds or min(seeds) < 1 or len(seeds) > 1000:
            self.fail(f"{value!r}: 1 to 1000 seeds from 1 on were expected", param, ctx)
        return tuple(dict.fromkeys(seeds))


@click.command()
@click.option("--board", "board_name", required=True, metavar="BOARD", help="Name of a board, or its own .toml file.")
@click.option("--rom", "rom_path", type=FILE, required=True, metavar="X.rom.json", help="ROM image of the correction.")
@click.option("--seeds", type=SeedList(), metavar="1-16", help="Seeds to try.  [default: those of the board's file]")
@click.option(
    "--strobe-delay",
    type=click.IntRange(0, (1 << STROBE_DELAY_BITS) - 1),
    default=0,
    show_default=True,
    metavar="SAMPLES",
    help="Strobe delay at power-up, in sample periods.",
)
@click.option("--self-test", "self_test_rps", type=float, metavar="RPS", help="Turn a generator in the FPGA instead.")
@click.option(
    "--self-test-fault", type=click.Choice(list(GENERATOR_FAULTS)), help="A fault for the self-test to inject."
)
@click.option(
    "--constraints",
    type=FILE,
    default=BOARD_FOLDER,
    show_default=True,
    metavar="FOLDER",
    help="Where the boards' files are.",
)
@click.option(
    "--build-folder",
    type=FILE,
    default=DEFAULT_BUILD_FOLDER,
    show_default=True,
    metavar="FOLDER",
    help="The bitstream goes to FOLDER/BOARD.",
)
def build(board_name, rom_path, seeds, strobe_delay, self_test_rps, self_test_fault, constraints, build_folder):
    """Build the bitstream for a board.

    Seeds are tried until every clock reaches its constraint. Ends with status 1 when none does, or a clock went
    unconstrained; then no bitstream is written.
    """
    rom = load_rom(rom_path)
    board = load_board(board_name, constraints)
    if seeds:
        board = dataclasses.replace(board, seeds=seeds)
    self_test = _self_test(board, self_test_rps, self_test_fault)
    folder = build_folder / board.name
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be made: {error.strerror or error}") from error
    try:
        placed = _place_with_bar(board, BoardTop(board, None, self_test=self_test, strobe_delay=strobe_delay))
        content, record = finish(board, placed, rom, self_test=self_test, strobe_delay=strobe_delay)
    except TimingFailed as error:
        write_files({folder / LOG_NAME: error.log.encode()})
        click.echo(f"arcref: {board.name} was not built: {error}", err=True)
        if not any(report.misuse for report in error.reports.values()):
            click.echo(f"arcref: try more seeds (--seeds 1-32), or lower clock.word_clock_hz of {board.name}", err=True)
        click.echo(f"arcref: log: {folder / LOG_NAME}", err=True)
        raise click.exceptions.Exit(1) from error
    except (ToolError, TablesNotFound, TablesDiffer) as error:
        click.echo(f"arcref: {board.name} was not built: {error}", err=True)
        raise click.exceptions.Exit(1) from error
    files = {
        folder / f"{DESIGN}{SUFFIX[board.family]}": content,
        folder / RECORD_NAME: record_json(record),
        folder / LOG_NAME: placed.log.encode(),
    }
    write_files(files)
    click.echo(printed(record, files), nl=False)


def finish(board: Board, placed: PlacedDesign, rom: CorrectionRom, **options) -> tuple[bytes, dict]:
    """Give a placed design its ROM; the bitstream and its record. The same inputs give the same bytes.

    Raises `TablesNotFound`, `TablesDiffer`, `ToolError`.
    """
    bitstream = BITSTREAMS[board.family](placed.bitstream)
    layout = locate_tables(bitstream, board.family)
    content = replace_tables(bitstream, layout, rom_contents(rom))
    record = build_record(board, placed, **options) | {
        "layout_sha256": layout.sha256(bitstream),
        "tables": layout.to_json(),
    }
    return content, with_rom(record, content, rom.crc32)


def build_record(board: Board, placed: PlacedDesign, *, self_test: SelfTest | None = None, strobe_delay=0) -> dict:
    """What `build.json` says of a placed design, but for its tables and its ROM."""
    report = placed.report
    return {
        "format": FORMAT,
        "version": VERSION,
        "arcref_version": __version__,
        "board": board.name,
        "title": board.title,
        "family": board.family,
        "device": board.device,
        "package": board.package,
        "speed": board.speed,
        "samples_per_word": board.samples_per_word,
        "oscillator_hz": board.oscillator_hz,
        "word_clock_hz": board.word_clock_hz,
        "word_clock_reached_hz": report.word_clock_reached_hz,
        **speed_figures(board.samples_per_word, report.word_clock_reached_hz),
        "as_clocked": speed_figures(board.samples_per_word, board.word_clock_hz),
        "cells": report.cells,
        "cells_available": report.cells_available,
        "flip_flops": report.flip_flops,
        "block_rams": report.block_rams,
        "block_rams_available": report.block_rams_available,
        "clocks": [dataclasses.asdict(clock) for clock in report.clocks],
        "seed": placed.seed,
        "seeds_tried": {str(seed): report and report.word_clock_reached_hz for seed, report in placed.tried.items()},
        "synthesis_options": list(board.synthesis_options),
        "strobe_delay_samples": strobe_delay,
        "has_link": board.has_link,
        "baud": board.baud if board.has_link else None,
        "capture_depth": board.capture_depth if board.has_link else None,
        "self_test": self_test and dataclasses.asdict(self_test),
        "tools": tool_versions(TOOLS[board.family]),
    }


def _self_test(board: Board, speed_rps: float | None, fault: str | None) -> SelfTest | None:
    if speed_rps is None:
        if fault is not None:
            raise InputError("--self-test-fault needs --self-test with a speed")
        return None
    self_test = SelfTest(speed_rps=speed_rps, fault=fault)
    self_test.rate(board.samples_per_s)
    return self_test


def _place_with_bar(board: Board, top: BoardTop) -> PlacedDesign:
    columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(board.name, total=1.0)
        return place_and_route(
            board, top, lambda text, part: bar.update(task, description=f"{board.name}: {text}", completed=part)
        )
