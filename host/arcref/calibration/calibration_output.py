"""What every verb of `arcref calibrate` writes and prints, and the options that say so."""

import json
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import click
from rich.console import Console
from rich.table import Table
from rich.text import Text

from arcref.angle import ARCSEC_PER_COUNT
from arcref.atomic_file import write_files
from arcref.calibration.calibration_result import CalibrationResult
from arcref.calibration.fit_sections import COMPARISON_TITLE
from arcref.calibration.fits.fit_names import DEFAULT_FIT, FIT_NAMES
from arcref.calibration.metadata_key import SUBDIVISION
from arcref.calibration_file import FORMAT, VERSION
from arcref.input_error import InputError
from arcref.output_files import check_outputs
from arcref.run_file import RunFile

FILE = click.Path(path_type=Path)

FIT_COLUMN_WIDTH = 25
"""Characters of a fit's name on the terminal: the headings beside it fold instead."""


@dataclass(frozen=True)
class OutputOptions:
    """What the options of `calibration_options` say."""

    run: Path
    output: Path
    report: Path | None
    json: Path | None
    csv: Path | None
    as_left: Path | None = None
    verify: Path | None = None
    fit: str = DEFAULT_FIT
    compare: bool = False
    inputs: tuple[Path, ...] = field(default=(), repr=False)

    def check(self) -> None:
        """Raises `InputError` when a file to be written cannot be: see `check_outputs`."""
        if self.output.suffix.lower() != ".json" or self.output.name.endswith(".rom.json"):
            raise InputError(f"{self.output}: the name of a calibration must end in .json, and not in .rom.json")
        inputs = [self.run, self.as_left, self.verify, *self.inputs]
        check_outputs([self.output, self.report, self.json, self.csv], inputs)


def calibration_options(verb: Callable) -> Callable:
    """The options that all methods share: the verb takes `run`, and one keyword for each."""
    for option in (
        click.option("--compare", is_flag=True, help="Fit by every method and compare what they leave."),
        click.option(
            "--fit",
            type=click.Choice(FIT_NAMES),
            default=DEFAULT_FIT,
            show_default=True,
            help="Curve through the errors that the report and the uncertainty stand on.",
        ),
        click.option(
            "--verify", type=FILE, metavar="RUN2.csv", help="A second run at other angles, to test the fit against."
        ),
        click.option(
            "--as-left",
            type=FILE,
            metavar="RUN2.csv",
            help="A run after adjustment or correction; RUN.csv is then the encoder as found, and both are reported.",
        ),
        click.option("--csv", "csv_path", type=FILE, metavar="FILE.csv", help="Write the table of results."),
        click.option("--json", "json_path", type=FILE, metavar="FILE.json", help="Write everything that was found."),
        click.option("--report", type=FILE, metavar="R.html", help="Write the report, one page to read and print."),
        click.option(
            "-o", "--output", type=FILE, required=True, metavar="CAL.json", help="Calibration to write, for arcref rom."
        ),
        click.argument("run", type=FILE, metavar="RUN.csv"),
    ):
        verb = option(verb)
    return verb


def calibration_json(result: CalibrationResult) -> dict:
    """The content of CAL.json, as DESIGN.md has it."""
    if result.kind == SUBDIVISION:
        abscissa, arc = {"line_deg": result.curve.line_deg.tolist()}, None
    else:
        abscissa, arc = {"angle_deg": result.curve.angle_deg.tolist()}, result.curve.arc_deg
    curve = abscissa | {
        "error_arcsec": result.curve.error_arcsec.tolist(),
        "u_arcsec": None if result.curve.u_arcsec is None else result.curve.u_arcsec.tolist(),
    }
    if arc is not None:
        curve["arc_deg"] = list(arc)
    return {
        "format": FORMAT,
        "version": VERSION,
        "kind": result.kind,
        "curve": curve,
        "results": result.results,
        "provenance": result.provenance,
    }


def finish_calibration(
    result: CalibrationResult, options: OutputOptions, as_left: CalibrationResult | None = None
) -> None:
    """Write the files, print what a person reads, and end with status 1 when a check failed.

    The calibration is that of the encoder as left when there are two: its correction is the one to use. Raises
    `InputError` when the two are of different encoders.
    """
    if as_left is not None:
        _refuse_another_encoder(result.run, as_left.run)
    final = as_left or result
    contents = {options.output: _json(calibration_json(final))}
    reports = _subdivision_reports if result.kind == SUBDIVISION else _turn_reports
    contents |= reports(result, as_left, options)
    write_files(contents)
    _print(result, as_left, list(contents))
    if not all(each.passed for each in (result, as_left) if each is not None):
        raise click.exceptions.Exit(1)


def _turn_reports(result: CalibrationResult, as_left: CalibrationResult | None, options: OutputOptions) -> dict:
    """The files of a report on the error over the turn, those that are wanted."""
    contents = {}
    if options.json:
        from arcref.calibration.report.calibration_record import calibration_record

        contents[options.json] = _json(calibration_record(result, as_left))
    if options.csv:
        from arcref.calibration.report.result_table import result_csv

        contents[options.csv] = result_csv(result, as_left).encode()
    if options.report:
        from arcref.calibration.report.calibration_page import calibration_page

        contents[options.report] = calibration_page(result, as_left).encode()
    return contents


def _subdivision_reports(result: CalibrationResult, as_left: None, options: OutputOptions) -> dict:
    """The files of a report on the error within a line, those that are wanted; it knows no run as left."""
    contents = {}
    if options.json or options.csv:
        from arcref.subdivision.report.subdivision_record import subdivision_csv, subdivision_record

        if options.json:
            contents[options.json] = _json(subdivision_record(result))
        if options.csv:
            contents[options.csv] = subdivision_csv(result).encode()
    if options.report:
        from arcref.subdivision.report.subdivision_page import subdivision_page

        contents[options.report] = subdivision_page(result).encode()
    return contents


def _refuse_another_encoder(found: RunFile, left: RunFile) -> None:
    serials = [run.metadata.get("encoder_serial") for run in (found, left)]
    if all(serials) and serials[0] != serials[1]:
        problem = (
            f"{serials[1]!r}, but {found.path.name} is of {serials[0]!r}: one encoder was expected, found and left"
        )
        raise left.metadata_error("encoder_serial", problem)


def _json(content: dict) -> bytes:
    return (json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False) + "\n").encode()


def _print(result: CalibrationResult, as_left: CalibrationResult | None, written: list[Path]) -> None:
    """The short table, what failed, what to mind, and where everything is."""
    console = Console(highlight=False)
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0), show_header=as_left is not None)
    table.add_column("", no_wrap=True)
    table.add_column("as found" if as_left else "", overflow="fold")
    rows = [[name, Text(value)] for name, value in result.figures]
    if as_left:
        table.add_column("as left", overflow="fold")
        left = dict(as_left.figures)
        rows = [[*row, Text(left.pop(row[0], "-"))] for row in rows]
        rows += [[name, Text("-"), Text(value)] for name, value in left.items()]
    rows.append(["written", Text("\n".join(map(str, written)))] + ([""] if as_left else []))
    for row in rows:
        table.add_row(*row)
    console.print(Text(f"Calibration ({result.kind}) from {result.run.path}", "bold"), soft_wrap=True)
    console.print(table)
    runs = {"as found: ": result, "as left: ": as_left} if as_left else {"": result}
    for prefix, each in runs.items():
        _print_comparison(console, each, prefix)
    for prefix, each in runs.items():
        for warning in each.warnings:
            console.print(Text(f"Caution: {prefix}{warning}", "yellow"), soft_wrap=True)
        for missing in each.budget.missing:
            name, key = missing.name, missing.metadata_key
            console.print(Text(f"Not in the budget: {prefix}{name}; state it as '# {key}: ...'"), soft_wrap=True)
        for check in each.checks:
            if not check.passed:
                console.print(Text(f"FAILED: {prefix}{check.sentence} ({check.found})", "red"), soft_wrap=True)
    console.print(
        Text(f"Resolution ({ARCSEC_PER_COUNT:.4f} arcsec a count) is not accuracy: of that the budget speaks."),
        soft_wrap=True,
    )


def _print_comparison(console: Console, result: CalibrationResult, prefix: str) -> None:
    """The table of the fits side by side, when they were compared; `prefix` says of which run."""
    for section in result.sections:
        if section.title == COMPARISON_TITLE:
            table = Table(box=None, pad_edge=False, padding=(0, 1, 0, 0), title=f"{prefix}{section.title} / arcsec")
            table.add_column(section.columns[0], min_width=FIT_COLUMN_WIDTH)
            for column in section.columns[1:]:
                # As wide as the longest word of its heading, which folds: the table fits 80 characters.
                table.add_column(column, justify="right", width=max(6, *map(len, column.split())))
            for row in section.rows:
                table.add_row(*row)
            console.print(table)
