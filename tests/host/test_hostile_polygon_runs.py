"""Polygon runs broken at random: each is reduced, or refused in one line that names the file; nothing else happens."""

import json
import random

import numpy as np
from made_polygon_run import STATED, polygon_run_text

from arcref.calibration.calibrate_polygon_command import reduced_run
from arcref.calibration.calibration_output import calibration_json
from arcref.calibration.polygon_result import polygon_result
from arcref.input_error import InputError

CELLS = ("", "0", "1e300", "-1e300", "1e-300", "999999", "nan", "x", "-0", "1,5", "3600", "360", "0.5", "-1")
KEYS = ("faces", "autocollimator_sign", "closing_limit_arcsec", "u_autocollimator_arcsec", "screw_pitch_mm")
KEYS += ("autocollimator_roll_arcmin", "tilt_limit_arcsec", "eccentricity_mm", "u_temperature_arcsec", "encoder_grade")
SCREWS = (("screw_angles_deg", "0 120 240"), ("screw_radius_mm", 60), ("screw_pitch_mm", 0.5))


def broken(lines: list[str], rng: random.Random) -> list[str]:
    """The lines with one thing wrong."""
    place, other = rng.randrange(len(lines)), rng.randrange(len(lines))
    match rng.randrange(7):
        case 0:
            return lines[:place] + lines[place + 1 :] or [""]
        case 1:
            return [*lines[:place], lines[other], *lines[place:]]
        case 2:
            cells = lines[place].split(",")
            cells[rng.randrange(len(cells))] = rng.choice(CELLS)
            return [*lines[:place], ",".join(cells), *lines[place + 1 :]]
        case 3:
            cut = rng.randrange(len(lines[place]) + 1)
            text = lines[place][:cut] + rng.choice(',;#":-+.e \t\0é0') + lines[place][cut + 1 :]
            return [*lines[:place], text, *lines[place + 1 :]]
        case 4:
            swapped = list(lines)
            swapped[place], swapped[other] = lines[other], lines[place]
            return swapped
        case 5:
            return [line if line.startswith("#") else line.rpartition(",")[0] for line in lines]
        case _:
            return [f"# {rng.choice(KEYS)}: {rng.choice(CELLS)}", *lines]


def test_a_broken_run_is_reduced_or_refused_in_one_line(tmp_path):
    rng, path = random.Random(2015), tmp_path / "run.csv"
    reduced = refused = 0
    for seed in range(250):
        text = polygon_run_text(
            faces=rng.choice((3, 4, 5, 7, 8)),
            rounds=rng.choice((1, 2)),
            directions=rng.choice(((1,), (1, -1))),
            psi_arcsec=rng.choice((None, 300.0)),
            metadata=(*rng.choice(((), STATED)), *SCREWS),
            seed=seed,
        )
        lines = text.splitlines()
        for _ in range(rng.choice((0, 1, 1, 2, 3))):
            lines = broken(lines, rng)
        path.write_text("\n".join(lines), encoding="utf-8")
        line = ""
        try:
            reduction, _ = reduced_run(path, None, True, accept_suspect=True)
            content = calibration_json(polygon_result(reduction))
        except InputError as error:
            line = str(error)
            refused += 1
        else:
            json.dumps(content, allow_nan=False)
            assert np.isfinite(content["curve"]["error_arcsec"]).all()
            reduced += 1
        assert not line or line.startswith(str(path))
        assert "\n" not in line
    assert min(reduced, refused) > 50
