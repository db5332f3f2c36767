"""The lines that README and manual show for a notebook read an angle from the twin."""

import re
from pathlib import Path

import pytest
from twin_truth import wait_until_homed

from arcref.angle import counts_to_deg
from arcref.link.port_finder import PORT_VARIABLE

PROJECT = Path(__file__).parents[3]


def shown_lines(page: str) -> list[str]:
    """The three lines of Python on a page, from its import of the client on."""
    text = (PROJECT / page).read_text(encoding="utf-8")
    lines = re.search(r"^ {4}(?:>>> )?from arcref import Encoder\n(?: {4}.*\n)+", text, re.MULTILINE)[0].splitlines()
    return [re.sub(r"^(>>>|\.\.\.) ", "", line[4:]) for line in lines]


@pytest.mark.parametrize("page", ["README.md", "docs/instrument.md"])
def test_three_lines_read_the_angle(make_twin, monkeypatch, capsys, tmp_path, page):
    lines = shown_lines(page)
    assert len(lines) == 3
    monkeypatch.chdir(tmp_path)
    link = tmp_path / "build" / "twin"  # where `arcref twin` puts it, and README looks
    with make_twin(speed_rps=10.0, link=link) as twin:
        wait_until_homed(twin)
        twin.set_speed(0.0)
        monkeypatch.setenv(PORT_VARIABLE, twin.port)
        exec("\n".join(lines), {})
        angle = re.fullmatch(r"([0-9.]+) deg\n", capsys.readouterr().out)[1]
        status = twin.status()
    assert abs(float(angle) - counts_to_deg(status.true_counts)) < 2 * counts_to_deg(1)
