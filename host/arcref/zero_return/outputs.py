"""What both commands of the zero-return test write and print."""

import json
from pathlib import Path

from rich.console import Console
from rich.table import Table
from rich.text import Text

from arcref.atomic_file import write_files
from arcref.zero_return.figures import figures
from arcref.zero_return.page import zero_return_page
from arcref.zero_return.record import zero_return_record
from arcref.zero_return.result import ZeroReturnResult


def write_outputs(result: ZeroReturnResult, page: Path | None, json_path: Path | None) -> None:
    """Write page and JSON, those that are named."""
    files = {}
    if page:
        files[page] = zero_return_page(result).encode()
    if json_path:
        files[json_path] = (json.dumps(zero_return_record(result), indent=2) + "\n").encode()
    write_files(files)


def print_result(result: ZeroReturnResult, page: Path | None) -> None:
    """What a person reads at the end."""
    table = Table(box=None, show_header=False, pad_edge=False, padding=(0, 2, 0, 0))
    table.add_column(no_wrap=True)
    table.add_column(overflow="fold")
    for name, value in figures(result):
        table.add_row(name, Text(value))
    console = Console(highlight=False)
    console.print(table)
    for check in result.checks:
        if not check.passed:
            console.print(Text(f"FAILED: {check.sentence} ({check.found})", "red"), soft_wrap=True)
    for fault in result.instrument.faults if result.instrument else ():
        console.print(Text(f"{fault.name}: {fault.action}"), soft_wrap=True)
    if page:
        console.print(Text(f"page: {page}"), soft_wrap=True)
    console.print("PASS" if result.passed else "FAIL", style="bold green" if result.passed else "bold red")
