"""The lines that the manual shows for a notebook read an angle from the twin."""

import re
from pathlib import Path

from twin_truth import wait_until_homed

from arcref.angle import counts_to_deg
from arcref.link.port_finder import PORT_VARIABLE

MANUAL = Path(__file__).parents[3] / "docs" / "instrument.md"


def test_three_lines_read_the_angle(make_twin, monkeypatch, capsys):
    shown = re.search(r"<!-- notebook -->\n(.*?)<!-- end notebook -->", MANUAL.read_text(encoding="utf-8"), re.DOTALL)[
        1
    ]
    lines = [line.strip()[4:] for line in shown.splitlines()]
    assert len(lines) == 3
    with make_twin(speed_rps=10.0) as twin:
        wait_until_homed(twin)
        twin.set_speed(0.0)
        monkeypatch.setenv(PORT_VARIABLE, twin.port)
        exec("\n".join(lines), {})
        angle = re.fullmatch(r"([0-9.]+) deg\n", capsys.readouterr().out)[1]
        status = twin.status()
    assert abs(float(angle) - counts_to_deg(status.true_counts)) < 2 * counts_to_deg(1)
