"""The reduction of a polygon run: sign, rounds, directions, closing error, repeatability, tilt and roll."""

from dataclasses import replace

import numpy as np
import pytest
from made_polygon_run import polygon_run_text
from scipy.spatial.transform import Rotation

from arcref.calibration.polygon_reduction import reduce_polygon, unreferenced_errors
from arcref.calibration.polygon_run import read_polygon_run
from arcref.calibration.tower_tilt import ARCSEC_PER_RADIAN, horizontal_reading_arcsec

HARMONICS = ((1, 2.0), (2, 1.0), (3, 0.7))


@pytest.fixture
def read(tmp_path):
    """Writes a run file and reads it."""

    def reader(text, **options):
        path = tmp_path / "run.csv"
        path.write_text(text, encoding="utf-8")
        return read_polygon_run(path, **options)

    return reader


@pytest.fixture
def reduced(read):
    """Reduces a made run: `reduced(tilt_correction=True, **made)`."""

    def reduce(tilt_correction=True, **made):
        return reduce_polygon(read(polygon_run_text(**made)), tilt_correction)

    return reduce


def true_error(faces, first_deg=0.0):
    angle = np.radians(first_deg + 360.0 / faces * np.arange(faces))
    error = sum(size * np.sin(order * angle + order) for order, size in HARMONICS)
    return error - error[0]


def errors_from_first(*readings):
    """Equation (1): less the first reading."""
    error = unreferenced_errors(*readings)
    return error - error[0]


def test_reduced_errors_by_hand():
    """e = (a - a1) - (b - b1) + sign (c - c1), worked on paper; whole turns of the position do not matter."""
    position = np.array([10.0, 100.0 + 1 / 3600, 190.0 - 2 / 3600, 280.0 + 720.0])
    nominal = np.array([10.0, 100.0, 190.0, 280.0])
    b, c = np.array([0.5, -1.0, 2.0, 0.25]), np.array([3.0, 4.0, 1.0, 3.5])
    plus = errors_from_first(position, nominal, b, c, +1)
    assert plus == pytest.approx([0, 1 + 1.5 + 1, -2 - 1.5 - 2, 0.25 + 0.5], abs=1e-6)
    minus = errors_from_first(position, nominal, b, c, -1)
    assert minus == pytest.approx([0, 1 + 1.5 - 1, -2 - 1.5 + 2, 0.25 - 0.5], abs=1e-6)
    assert errors_from_first(position, nominal, None, c, +1) == pytest.approx([0, 1 + 1, -2 - 2, 0.5], abs=1e-6)


@pytest.mark.parametrize("faces", [8, 24])
@pytest.mark.parametrize(("psi_arcsec", "left"), [(300.0, 6e-6), (600.0, 5e-5)])
def test_a_perfect_encoder_with_tower_tilt_shows_plus_eps_x(faces, psi_arcsec, left):
    """Equation (1) is printed with a minus before (c - c1); in the paper's own frame only the plus is right.

    The shaft turns by -theta about the tilted axis, by SciPy; c is positive towards OY. What the plus leaves is taken
    away by the simplified law (12) to 6e-6 and 5e-5 arcsec, and by the exact model altogether.
    """
    theta_deg = np.arange(faces) * 360.0 / faces
    theta, omega_deg = np.radians(theta_deg), 67.0
    psi, omega = psi_arcsec / ARCSEC_PER_RADIAN, np.radians(omega_deg)
    axis = np.array([np.sin(psi) * np.cos(omega), np.sin(psi) * np.sin(omega), np.cos(psi)])
    normal = np.stack([np.cos(theta), np.sin(theta), np.zeros(faces)], axis=1)
    seen = Rotation.from_rotvec(-theta[:, np.newaxis] * axis).apply(normal)
    c = np.arctan2(seen[:, 1], seen[:, 0]) * ARCSEC_PER_RADIAN
    right = errors_from_first(theta_deg, theta_deg, np.zeros(faces), c, +1)
    assert np.ptp(right) > 0.3
    exact = horizontal_reading_arcsec(theta_deg, psi_arcsec, omega_deg)
    assert np.abs(right - exact).max() < 1e-9
    f = np.sin(omega) * (1 - np.cos(theta)) * np.cos(omega - theta) + np.sin(theta) * np.cos(theta) / 2
    assert np.abs(right - psi_arcsec**2 / ARCSEC_PER_RADIAN * f).max() < left
    wrong = errors_from_first(theta_deg, theta_deg, np.zeros(faces), c, -1)
    assert np.abs(wrong - exact).max() > 0.3


@pytest.mark.parametrize("faces", [7, 8, 12, 17, 23, 24, 36, 72])
@pytest.mark.parametrize("directions", [(1,), (1, -1), (-1,)])
def test_any_number_of_faces_rounds_and_directions(reduced, faces, directions):
    reduction = reduced(faces=faces, directions=directions, rounds=2, noise_arcsec=0.0, psi_arcsec=300.0, first_deg=3.2)
    assert reduction.angle_deg == pytest.approx(3.2 + 360.0 / faces * np.arange(faces))
    assert np.abs(reduction.error_arcsec - true_error(faces, 3.2)).max() < 0.012  # y noise and the file's digits
    assert reduction.error_of_series_arcsec.shape == (2 * len(directions), faces)
    assert reduction.closing_error_arcsec == pytest.approx(np.zeros(2 * len(directions)), abs=2e-3)


def test_the_sign_is_switchable(read):
    text = polygon_run_text(noise_arcsec=0.0)
    flipped = []
    for line in text.splitlines():
        cells = line.split(",")
        if cells[0].isdigit():
            cells[-1] = str(-float(cells[-1]))
        flipped.append(",".join(cells))
    with_minus = "# autocollimator_sign: -1\n" + "\n".join(flipped)
    for run in (read(text), read(with_minus), read("\n".join(flipped), sign=-1)):
        assert np.abs(reduce_polygon(run).error_arcsec - true_error(24)).max() < 1e-3
    assert read(text).sign_basis == "assumed: the run file states no autocollimator_sign"
    assert read(with_minus).sign_basis == "by the run file"
    assert read(with_minus, sign=1).sign_basis == "by the command's option, against -1 in the run file"


def test_closing_error_of_each_round(reduced):
    """H = |c1' - c1|, kept with its sign: drift of 0.6 arcsec in each round, and the position's own difference."""
    reduction = reduced(noise_arcsec=0.0, drift_arcsec=0.6, rounds=3, directions=(1, -1))
    assert reduction.closing_error_arcsec == pytest.approx(np.full(6, 0.6), abs=2e-3)


def test_a_closing_position_that_differs_counts_too(read):
    lines = polygon_run_text(noise_arcsec=0.0, rounds=1).splitlines()
    cells = lines[-1].split(",")
    cells[2] = f"{float(cells[2]) + 1.0 / 3600:.8f}"  # the shaft stopped 1 arcsec further and x says nothing of it
    reduction = reduce_polygon(read("\n".join([*lines[:-1], ",".join(cells)])))
    assert reduction.closing_error_arcsec == pytest.approx([1.0], abs=2e-3)


def test_rounds_that_were_not_closed_have_no_closing_error(read):
    lines = polygon_run_text(rounds=2).splitlines()
    rows = [line for line in lines if not line.startswith("1,1,360.") and not line.startswith("2,1,360.")]
    assert len(rows) == len(lines) - 2
    assert np.isnan(reduce_polygon(read("\n".join(rows))).closing_error_arcsec).all()


@pytest.mark.parametrize("directions", [(1,), (1, -1)])
def test_repeatability_is_the_noise_of_one_reading(reduced, directions):
    found = [
        reduced(seed=seed, noise_arcsec=0.25, rounds=3, directions=directions, return_arcsec=1.0) for seed in range(40)
    ]
    squares = np.mean([reduction.repeatability_arcsec**2 for reduction in found])
    assert np.sqrt(squares) == pytest.approx(0.25, rel=0.03)
    assert {reduction.degrees_of_freedom for reduction in found} == {2 * 23 * len(directions)}


def test_one_round_says_nothing_of_repeatability(reduced):
    reduction = reduced(rounds=1, directions=(1, -1))
    assert np.isnan(reduction.repeatability_arcsec)
    assert reduction.degrees_of_freedom == 0


def test_return_error_holds_its_constant(reduced):
    """Forward minus backward. Zeroing each series at its first face would lose a constant return error."""
    reduction = reduced(noise_arcsec=0.0, return_arcsec=0.8, directions=(1, -1))
    assert reduction.return_error_arcsec == pytest.approx(np.full(24, 0.8), abs=2e-3)
    assert reduced(directions=(1,)).return_error_arcsec is None


def test_each_direction_counts_half(read):
    """Two rounds forward and one backward: the mean is that of the directions, not of the series."""
    text = polygon_run_text(noise_arcsec=0.0, rounds=2, directions=(1, -1))
    lines = [line for line in text.splitlines() if not line.startswith("2,-1")]
    rows = []
    for line in lines:
        cells = line.split(",")
        if cells[:2] == ["1", "-1"] and not cells[2].startswith(("0.0", "360.0")):
            cells[-1] = f"{float(cells[-1]) + 1.0:.4f}"  # backward reads 1 arcsec more at all faces but the first
        rows.append(",".join(cells))
    run = read("\n".join(rows))
    assert run.series.weight == pytest.approx([0.25, 0.5, 0.25])
    assert reduce_polygon(run).error_arcsec[5] - true_error(24)[5] == pytest.approx(0.5, abs=2e-3)


def test_tilt_is_taken_off_by_default_and_reported_either_way(reduced):
    made = {"psi_arcsec": 1369.0, "omega_deg": 67.5, "noise_arcsec": 0.0, "y_noise_arcsec": 0.1, "rounds": 1}
    on, off = reduced(**made), reduced(tilt_correction=False, **made)
    assert np.sqrt(np.mean((on.error_arcsec - true_error(24)) ** 2)) < 0.002
    assert np.abs(off.error_arcsec - true_error(24)).max() > 5
    assert (off.uncorrected_error_arcsec == off.error_arcsec).all()
    assert (on.uncorrected_error_arcsec == off.error_arcsec).all()
    assert (on.tilt_corrected, off.tilt_corrected) == (True, False)
    assert on.tilt.psi_arcsec == off.tilt.psi_arcsec == pytest.approx(1369, abs=0.1)
    assert (on.x_correction_arcsec == off.x_correction_arcsec).all()


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("roll_arcmin", [5.0, -60.0])
def test_roll_is_taken_off(read, sign, roll_arcmin):
    """x and y as a rolled autocollimator shows them; the roll as stated frees both from each other."""
    plain = polygon_run_text(noise_arcsec=0.0, y_noise_arcsec=0.0, psi_arcsec=300.0, rounds=1)
    roll = np.radians(roll_arcmin / 60)
    rows = [f"# autocollimator_roll_arcmin: {roll_arcmin}", f"# autocollimator_sign: {sign}"]
    for line in plain.splitlines():
        cells = line.split(",")
        if cells[0].isdigit():
            x, y = sign * float(cells[-2]), float(cells[-1])
            cells[-2:] = [f"{x * np.cos(roll) + y * np.sin(roll):.5f}", f"{y * np.cos(roll) - x * np.sin(roll):.5f}"]
        rows.append(",".join(cells))
    run = read("\n".join(rows))
    reduction = reduce_polygon(run)
    assert np.abs(reduction.error_arcsec - true_error(24)).max() < 1e-3
    assert np.abs(reduce_polygon(replace(run, roll_arcmin=None)).error_arcsec - true_error(24)).max() > 0.4


def test_the_sign_of_y_turns_the_azimuth_and_leaves_the_errors(read):
    text = polygon_run_text(psi_arcsec=300.0, omega_deg=40.0)
    run = read(text)
    there, back = reduce_polygon(run), reduce_polygon(replace(run, y_sign=-1))
    assert (back.tilt.omega_deg - there.tilt.omega_deg) % 360 == pytest.approx(180, abs=1e-3)
    assert back.error_arcsec == pytest.approx(there.error_arcsec, abs=1e-4)


def test_simulated_repetitions_are_reduced_at_once(read):
    run = read(polygon_run_text(psi_arcsec=300.0, directions=(1, -1), rounds=2))
    random = np.random.default_rng(4)
    x = run.x_arcsec + random.normal(0, 0.1, (2, 5, run.x_arcsec.size))
    y = run.y_arcsec + random.normal(0, 0.1, x.shape)
    together = reduce_polygon(replace(run, x_arcsec=x, y_arcsec=y))
    assert together.error_arcsec.shape == (2, 5, 24)
    alone = reduce_polygon(replace(run, x_arcsec=x[1, 3], y_arcsec=y[1, 3]))
    for name in (
        "error_arcsec", "error_of_series_arcsec", "closing_error_arcsec", "return_error_arcsec", "x_correction_arcsec",
        "repeatability_arcsec", "uncorrected_error_arcsec", "residual_arcsec",
    ):  # fmt: skip
        assert getattr(together, name)[1, 3] == pytest.approx(getattr(alone, name), abs=1e-10), name
    assert together.tilt.psi_arcsec[1, 3] == pytest.approx(alone.tilt.psi_arcsec)
