"""What settings of a polygon separate: encoder errors, face deviations and mountings."""

import numpy as np
import pytest

from arcref.calibration.closure_design import SettingsDesign


def design(faces, settings, step_deg, rounds=1) -> SettingsDesign:
    """All faces at all settings (numbers from 1), in every round."""
    round_, setting, face = np.meshgrid(np.arange(rounds), settings, np.arange(faces), indexing="ij")
    return SettingsDesign.of(faces, step_deg, setting.ravel(), face.ravel(), round_.ravel())


@pytest.mark.parametrize("faces", [7, 8, 12, 17, 23, 24, 36])
def test_a_whole_set_separates_every_order_and_reads_each_as_well(faces):
    whole = design(faces, range(1, faces + 1), 360 / faces)
    assert len(whole.position_deg) == faces
    assert whole.lost_orders == ()
    assert whole.degrees_of_freedom == faces**2 - (3 * faces - 2)
    np.testing.assert_allclose(whole.noise_factor, 1.0, rtol=1e-9)
    # Each error is the mean of as many readings as there are settings, but for the datum.
    u = np.sqrt(np.diag(whole.covariance))
    np.testing.assert_allclose(u, np.sqrt((1 - 1 / faces) / faces), rtol=1e-9)


@pytest.mark.parametrize(
    ("settings", "step_deg", "lost"),
    [
        (range(1, 6), 15, ()),
        (range(1, 6), 60, (6, 12)),
        (range(1, 4), 120, (3, 6, 9, 12)),
        ([1, 2], 180, (2, 4, 6, 8, 10, 12)),
        ([1, 2], 15, ()),
        ([1, 3, 5], 15, (12,)),
        ([1], 15, tuple(range(1, 13))),
    ],
)
def test_the_orders_that_a_partial_set_of_24_faces_loses(settings, step_deg, lost):
    assert design(24, settings, step_deg).lost_orders == lost


@pytest.mark.parametrize("seed", range(20))
def test_lost_orders_are_those_whose_phase_is_the_same_at_every_setting(seed):
    random = np.random.default_rng(seed)
    faces = int(random.integers(5, 31))
    settings = np.unique(random.integers(1, faces + 1, random.integers(2, 7)))
    turns = np.exp(2j * np.pi * np.outer(np.arange(1, faces // 2 + 1), settings) / faces)
    alike = np.isclose(np.abs(turns.sum(axis=1)), len(settings), rtol=1e-9)
    partial = design(faces, settings, 360 / faces)
    assert partial.lost_orders == tuple(np.flatnonzero(alike) + 1)
    # Noise of the orders that are kept: the normal equations of one order are [[m, S*], [S, m]].
    square = np.abs(turns.sum(axis=1)) ** 2
    m = len(settings)
    expected = np.sqrt(m**2 / (m**2 - square[~alike]))
    np.testing.assert_allclose(partial.noise_factor[~alike], expected, rtol=1e-7)


def test_positions_between_the_faces_leave_the_two_mountings_of_the_nets_apart():
    """At half the face spacing, even and odd settings share no position: order 24 is the difference of their datums."""
    half = design(24, range(1, 49), 7.5)
    assert len(half.position_deg) == 48
    assert half.lost_orders == (24,)
    assert half.lost_to_mountings
    assert not half.lost_from_faces.any()
    assert not design(24, range(1, 6), 60).lost_to_mountings


def test_five_settings_that_share_no_position_lose_the_faces_orders_and_leave_nothing_to_check():
    apart = design(24, range(1, 6), 72)
    assert len(apart.position_deg) == 120
    assert apart.degrees_of_freedom == 0
    assert apart.lost_orders == tuple(sorted({*range(5, 61, 5), 24, 48}))


def test_a_step_written_with_few_decimals_is_one_grid():
    assert len(design(7, range(1, 8), 51.4286).position_deg) == 7


def test_a_step_that_is_nearly_the_face_spacing_is_refused():
    with pytest.raises(ValueError, match="neither one position nor several"):
        design(24, range(1, 25), 15.004)


def test_what_is_lost_leaves_every_reading_as_it_is():
    partial = design(24, range(1, 6), 60)
    assert partial.lost.shape[1] == 3
    assert np.abs(partial.matrix @ partial.lost).max() < 1e-9


@pytest.mark.parametrize("seed", range(10))
def test_without_noise_the_truth_comes_back_whatever_readings_are_missing(seed):
    random = np.random.default_rng(seed)
    whole = design(12, range(1, 13), 30, rounds=2)
    kept = random.random(whole.readings) > 0.6
    encoder, face = random.normal(0, 3, 12), random.normal(0, 2, 12)
    mounting = random.uniform(-600, 600, whole.series_count)
    reading = (encoder[whole.position] + face[whole.face] + mounting[whole.series])[kept]
    setting, number = whole.series % 12 + 1, whole.face
    missing = SettingsDesign.of(12, 30, setting[kept], number[kept], (whole.series // 12)[kept])
    if missing.lost.shape[1] == 0:
        found = missing.estimator @ reading
        np.testing.assert_allclose(found[:12], encoder - encoder.mean(), atol=1e-8)
        np.testing.assert_allclose(found[12:24], face - face.mean(), atol=1e-8)
    else:
        np.testing.assert_allclose(missing.matrix @ (missing.estimator @ reading), reading, atol=1e-8)


def test_a_face_that_was_never_read_is_no_unknown():
    setting, face = np.meshgrid(range(1, 9), [0, 1, 2, 4, 5, 6, 7], indexing="ij")
    seven = SettingsDesign.of(8, 45, setting.ravel(), face.ravel())
    assert list(seven.faces) == [0, 1, 2, 4, 5, 6, 7]
    assert len(seven.position_deg) == 8
    assert seven.lost_orders == ()
