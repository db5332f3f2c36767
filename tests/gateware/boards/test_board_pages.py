"""The boards' pages and drawings say what the boards' files say."""

from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import pytest

from arcref_gateware.boards.board_file import board_names, load_board
from arcref_gateware.boards.board_pages import margin_table, page_files, pin_table
from arcref_gateware.boards.wiring_drawing import SOURCES, wiring_drawing

ROOT = Path(__file__).parents[3]
CONSTRAINTS = ROOT / "constraints"
BOARDS = board_names(CONSTRAINTS)
SVG = "{http://www.w3.org/2000/svg}"


def test_pages_and_drawings_are_those_of_the_boards():
    for path, text in page_files(ROOT / "docs" / "boards", CONSTRAINTS).items():
        assert path.read_text(encoding="utf-8") == text, f"{path} differs from its board: run `make manual`"


@pytest.mark.parametrize("name", BOARDS)
def test_a_page_has_both_tables_and_the_drawing(name):
    board = load_board(name, CONSTRAINTS)
    page = (ROOT / "docs" / "boards" / f"{name}.md").read_text(encoding="utf-8")
    assert pin_table(board) in page
    assert margin_table(board) in page
    assert f"]({name}.svg)" in page
    assert "**Where to buy.**" in page
    assert "**Levels.**" in page


@pytest.mark.parametrize("name", BOARDS)
def test_a_drawing_shows_every_wire_once(name):
    board = load_board(name, CONSTRAINTS)
    drawing = ElementTree.fromstring(wiring_drawing(board))
    texts = [text.text for text in drawing.iter(f"{SVG}text")]
    wired = [board.pins[signal] for _, signals, _ in SOURCES for signal in signals if signal in board.pins]
    for pin in wired:
        assert texts.count(pin.label or " ".join(pin.names)) == 1
        assert sum(text.startswith(f"ball {' '.join(pin.balls)},") for text in texts) == 1
    lines = drawing.findall(f"{SVG}line")
    assert len(lines) == sum(len(pin.balls) for pin in wired if pin.signal != "alignment")
    height = float(drawing.get("height"))
    assert all(0 < float(line.get("y1")) == float(line.get("y2")) < height for line in lines)


def test_a_drawing_changes_with_its_board():
    board = load_board(BOARDS[0], CONSTRAINTS)
    moved = board.pins | {"a": replace(board.pins["a"], balls=("X99",))}
    assert wiring_drawing(board) != wiring_drawing(replace(board, pins=moved))
    assert "X99" in wiring_drawing(replace(board, pins=moved))
