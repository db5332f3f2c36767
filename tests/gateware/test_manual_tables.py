"""The manual says what the contract says, and its examples run."""

import doctest
from pathlib import Path

import pytest

from arcref.input_error import InputError
from arcref.manual_tables import fill_page
from arcref_gateware.manual_tables import TABLES

ROOT = Path(__file__).parents[2]
PAGES = ["README.md", "docs/core.md", "docs/calibration.md", "docs/instrument.md"]


@pytest.mark.parametrize("page", PAGES)
def test_tables_of_the_manual_are_those_of_the_contract(page):
    text = (ROOT / page).read_text(encoding="utf-8")
    assert fill_page(text, TABLES) == text, "run `make manual`"


def test_every_table_stands_in_some_page():
    text = "".join((ROOT / page).read_text(encoding="utf-8") for page in PAGES)
    for name in TABLES:
        assert f"<!-- table {name} -->\n| " in text


def test_a_mark_without_a_table_is_refused():
    with pytest.raises(InputError, match="asks for a table 'prots'"):
        fill_page("<!-- table prots -->\n<!-- end prots -->", TABLES)


def test_examples_of_the_readme_run():
    failed, tried = doctest.testfile(str(ROOT / "README.md"), module_relative=False)
    assert tried >= 3
    assert failed == 0
