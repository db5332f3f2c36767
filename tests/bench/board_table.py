"""What each board reaches, out of the records that `arcref build` left: `board_table.py BUILD_FOLDER BOARD...`."""

import json
import sys
from pathlib import Path

from rich.console import Console
from rich.table import Table

TARGETS_HZ = {"ulx3s": (160e6, 200e6), "hx8k": (168e6, 200e6), "icebreaker": (84e6, 96e6)}
"""Word clock that a board must reach after routing, and the goal."""


def row(board: str, record: dict | None) -> list[str]:
    """One board's line of the table; `record` is None when it was not built."""
    must_hz, goal_hz = TARGETS_HZ.get(board, (None, None))
    targets = ["-" if hz is None else f"{hz / 1e6:g}" for hz in (must_hz, goal_hz)]
    if record is None:
        return [board, "-", "-", *targets, "not built", *["-"] * 7]
    reached_hz = record["word_clock_reached_hz"]
    verdict = ""
    if must_hz is not None:
        verdict = "  below" if reached_hz < must_hz else "  goal" if reached_hz >= goal_hz else "  ok"
    clocked = record["as_clocked"]
    return [
        board,
        f"{record['device']}" + (f" speed {record['speed']}" if record["speed"] else ""),
        str(record["samples_per_word"]),
        *targets,
        f"{reached_hz / 1e6:.1f}{verdict}",
        f"{record['word_clock_hz'] / 1e6:g}",
        f"{clocked['samples_per_s'] / 1e6:g}",
        f"{clocked['highest_speed_1_samples_per_count_rps']:.1f}",
        f"{clocked['highest_speed_1_5_samples_per_count_rps']:.1f}",
        f"{record['cells']} of {record['cells_available']}",
        f"{record['block_rams']}, seed {record['seed']}",
        "yes" if record["has_link"] else "no",
    ]


def main(folder: str, *boards: str) -> None:
    """Print the table."""
    table = Table(
        *("board", "part", "samples\na word", "must\nMHz", "goal\nMHz", "reached\nMHz", "clocked\nMHz"),
        *("M samples/s\nas clocked", "r/s at 1\na count", "r/s at\n1.5", "cells", "block\nRAMs", "serial\nlink"),
        box=None,
        pad_edge=False,
        title="The complete design of each board, after place and route",
        title_justify="left",
    )
    for board in boards:
        path = Path(folder, board, "build.json")
        table.add_row(*row(board, json.loads(path.read_text()) if path.exists() else None))
    Console(width=150, highlight=False).print(table)


if __name__ == "__main__":
    main(*sys.argv[1:])
