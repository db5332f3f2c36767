"""The boards' pages in docs/boards: drawing, table of pins and margins, made from the boards' files.

`make manual` writes them; a test fails when a page and its board differ. Run as a module: `board_pages docs/boards`.
"""

import sys
from pathlib import Path

from arcref.angle import COUNTS_PER_TURN
from arcref.atomic_file import write_text
from arcref.manual_tables import fill_page, markdown_table
from arcref_gateware.boards.board import Board
from arcref_gateware.boards.board_file import BOARD_FOLDER, board_names, load_board
from arcref_gateware.boards.build_record import highest_speed_rps
from arcref_gateware.boards.wiring_drawing import wiring_drawing

SPEED_RPS = 10.0
"""The speed at which the margin is stated."""


def pin_table(board: Board) -> str:
    """Every signal: where it is on the board, on the package, and what the pad is set to."""
    rows = [
        [
            f"`{pin.signal}`",
            {"i": "to the board", "o": "from the board", "io": "leave it open"}[pin.direction],
            pin.label or " ".join(pin.names),
            " ".join(pin.balls),
            pin.io_standard + (f", {pin.termination_ohm} ohm inside" if pin.termination_ohm else ""),
            pin.pull + (", inverted" if pin.inverted else ""),
        ]
        for pin in board.pins.values()
    ]
    return markdown_table(["signal", "direction", "on the board", "ball", "I/O standard", "pull"], rows)


def margin_table(board: Board) -> str:
    """What the word clock of the board's file gives."""
    counts_per_s = SPEED_RPS * COUNTS_PER_TURN
    samples_per_count = board.samples_per_s / counts_per_s
    # Two edges in neighbouring samples are still told apart; that they are raises flag 2.
    sample_ns = 1e9 / board.samples_per_s
    rows = [
        ["word clock", f"{board.word_clock_hz / 1e6:g} MHz, {board.samples_per_word} samples a word"],
        ["samples", f"{board.samples_per_s / 1e6:g} M/s, one each {sample_ns:.2f} ns"],
        ["at 10 r/s", f"{samples_per_count:.2f} samples a count; edges {1e9 / counts_per_s:.2f} ns apart on average"],
        ["edges may bunch to", f"{2 * sample_ns:.2f} ns before flag 2 is raised, {sample_ns:.2f} ns before counts go"],
        ["highest speed at 1.5 samples a count", f"{highest_speed_rps(board.samples_per_s, 1.5):.1f} r/s"],
        ["highest speed at 1 sample a count", f"{highest_speed_rps(board.samples_per_s, 1.0):.1f} r/s"],
    ]
    return markdown_table(["", f"{board.title}"], rows)


def page_files(folder: Path, constraints: Path = BOARD_FOLDER) -> dict[Path, str]:
    """What every board's page and drawing should hold, by path; the pages' own words are kept."""
    files = {}
    for name in board_names(constraints):
        board = load_board(name, constraints)
        page = folder / f"{name}.md"
        tables = {"pins": pin_table(board), "margin": margin_table(board)}
        files[page] = fill_page(page.read_text(encoding="utf-8"), tables)
        files[folder / f"{name}.svg"] = wiring_drawing(board)
    return files


if __name__ == "__main__":
    for path, text in page_files(Path(sys.argv[1])).items():
        write_text(path, text)
