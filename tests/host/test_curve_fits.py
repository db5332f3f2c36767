"""What holds for every fit behind the interface, whatever its method."""

import json
from dataclasses import replace

import numpy as np
import pytest

from arcref.calibration.fits.fit_names import FIT_NAMES, fit_curve
from arcref.calibration.fits.gaussian_process_fit import GaussianProcessFit
from arcref.error_curve import ErrorCurve
from arcref.input_error import InputError
from arcref.radial_basis_network import RadialBasisNetwork

INTERPOLATING = ("rbf", "spline")


def curve_of(angle_deg, u_arcsec=0.2, arc_deg=None, seed=1):
    """Low harmonics and noise at these angles."""
    random = np.random.default_rng(seed)
    angle = np.radians(angle_deg)
    error = 1.2 * np.cos(angle - 1) + 0.6 * np.sin(2 * angle) + 0.3 * np.cos(5 * angle) + 0.4
    error += 0.2 * random.standard_normal(angle.size)
    u = None if u_arcsec is None else u_arcsec * random.uniform(0.5, 1.5, angle.size)
    return ErrorCurve(angle_deg, error, u, arc_deg=arc_deg)


def unequal_deg(faces=23, seed=4):
    """Angles up to a third of their spacing away from equal distances."""
    random = np.random.default_rng(seed)
    return (np.arange(faces) + random.uniform(-1 / 3, 1 / 3, faces)) * 360 / faces + 17


CURVES = {
    "24 faces": curve_of(np.arange(24) * 15.0),
    "7 faces": curve_of(np.arange(7) * 360 / 7),
    "turned": curve_of(np.arange(17) * 360 / 17 - 123.4),
    "unequal": curve_of(unequal_deg()),
    "no uncertainty": curve_of(np.arange(24) * 15.0, None),
    "arc": curve_of(np.arange(0.0, 41.0, 2), arc_deg=(0.0, 40.0)),
    "arc over zero, unequal": curve_of(np.sort(unequal_deg(20) / 6 - 30), arc_deg=(-29.0, 38.0)),
}

each_fit = pytest.mark.parametrize("name", FIT_NAMES)
each_curve = pytest.mark.parametrize("curve", CURVES.values(), ids=CURVES.keys())


def angles_of(curve, count=301):
    first, last = curve.arc_deg or (curve.angle_deg[0], curve.angle_deg[0] + 360)
    return np.linspace(first, last, count)


@each_fit
@each_curve
def test_value_is_the_weighted_sum_of_the_errors(curve, name):
    fit = fit_curve(curve, name)
    angle = angles_of(curve)
    weights = fit.weights(angle)
    assert weights.shape == (angle.size, curve.angle_deg.size)
    assert np.abs(weights @ curve.error_arcsec - fit.evaluate(angle)).max() < 1e-10
    assert fit.weights(angle.reshape(7, 43)).shape == (7, 43, curve.angle_deg.size)
    assert fit.evaluate(angle.reshape(7, 43)).shape == (7, 43)
    assert fit.evaluate(float(angle[3])).shape == ()


@each_fit
@each_curve
def test_linear_with_its_parameters_kept(curve, name):
    fit = fit_curve(curve, name)
    other = replace(curve, error_arcsec=np.random.default_rng(7).standard_normal(curve.angle_deg.size))
    again = fit_curve(other, name, **fit.parameters)
    angle = angles_of(curve)
    assert np.abs(fit.weights(angle) @ other.error_arcsec - again.evaluate(angle)).max() < 1e-9


@each_fit
@each_curve
def test_leave_one_out_is_that_of_refitting_by_hand(curve, name):
    fit = fit_curve(curve, name)
    for face in range(0, curve.angle_deg.size, 3):
        others = np.arange(curve.angle_deg.size) != face
        u = None if curve.u_arcsec is None else curve.u_arcsec[others]
        rest = ErrorCurve(curve.angle_deg[others], curve.error_arcsec[others], u, arc_deg=curve.arc_deg)
        foretold = fit_curve(rest, name, **fit.parameters).evaluate(curve.angle_deg[face])
        assert fit.leave_one_out_arcsec[face] == pytest.approx(curve.error_arcsec[face] - foretold, abs=1e-8)


@each_fit
@each_curve
def test_propagated_uncertainty_is_that_of_many_draws(curve, name):
    fit = fit_curve(curve, name)
    angle = angles_of(curve, 40)
    if curve.u_arcsec is None:
        assert fit.u_arcsec(angle) is None
        return
    random = np.random.default_rng(5)
    drawn = random.standard_normal((40_000, curve.angle_deg.size)) * curve.u_arcsec
    found = (drawn @ fit.weights(angle).T).std(axis=0)
    assert fit.u_arcsec(angle) == pytest.approx(found, rel=0.03)


@each_fit
def test_propagated_uncertainty_of_correlated_faces(name):
    curve = CURVES["24 faces"]
    fit = fit_curve(curve, name)
    angle = angles_of(curve, 40)
    factor = np.random.default_rng(6).standard_normal((24, 24)) * 0.1
    drawn = np.random.default_rng(5).standard_normal((40_000, 24)) @ factor.T
    found = (drawn @ fit.weights(angle).T).std(axis=0)
    assert fit.u_arcsec(angle, factor @ factor.T) == pytest.approx(found, rel=0.03)
    together = fit.u_arcsec(angle, np.full((24, 24), 0.04))
    # What all faces have in common reaches every angle whole: no fit takes it for shape.
    assert together == pytest.approx(0.2, rel=0.002)


@each_fit
@each_curve
def test_residual_and_meeting_the_faces(curve, name):
    fit = fit_curve(curve, name)
    assert np.abs(curve.error_arcsec - fit.evaluate(curve.angle_deg) - fit.residual_arcsec).max() < 1e-12
    largest = np.abs(fit.residual_arcsec).max()
    assert largest < 1e-9 if name in INTERPOLATING else 1e-4 < largest < 1


@each_fit
@pytest.mark.parametrize("key", ["24 faces", "7 faces", "turned", "unequal"])
def test_neither_jump_nor_kink_at_the_seam(key, name):
    curve = CURVES[key]
    fit = fit_curve(curve, name)
    around = fit.evaluate(curve.angle_deg[0] + np.array([-1e-3, 0.0, 1e-3]))
    assert np.abs(np.diff(around)).max() < 1e-3
    assert abs(np.diff(around, 2)[0]) < 1e-6
    angle = angles_of(curve)
    assert np.abs(fit.evaluate(angle + 720) - fit.evaluate(angle)).max() < 1e-9


@each_fit
def test_origin_of_the_angles_does_not_matter(name):
    curve = CURVES["unequal"]
    fit = fit_curve(curve, name)
    turned = replace(curve, angle_deg=curve.angle_deg - 111.0)
    again = fit_curve(turned, name, **fit.parameters)
    angle = angles_of(curve)
    assert np.abs(again.evaluate(angle - 111) - fit.evaluate(angle)).max() < 1e-9
    if curve.u_arcsec is not None:
        assert again.u_arcsec(angle - 111) == pytest.approx(fit.u_arcsec(angle), abs=1e-9)


@each_fit
@pytest.mark.parametrize("key", ["arc", "arc over zero, unequal"])
def test_outside_an_arc_there_is_nothing(key, name):
    curve = CURVES[key]
    fit = fit_curve(curve, name)
    first, last = curve.arc_deg
    outside = np.linspace(last + 0.01, first + 359.99, 400)
    assert not fit.covers(outside).any()
    assert not fit.evaluate(outside).any()
    assert not fit.weights(outside).any()
    assert np.isnan(fit.u_arcsec(outside)).all()
    assert np.isnan(fit.interpolation_u_arcsec(outside)).all()
    inside = np.linspace(first, last, 200)
    for turn in (-360, 0, 360):
        assert fit.covers(inside + turn).all()
        for values in (fit.evaluate, fit.u_arcsec, fit.interpolation_u_arcsec):
            assert np.abs(values(inside + turn) - values(inside)).max() < 1e-9


@each_fit
@pytest.mark.parametrize("faces", [3, 4, 5, 8, 12, 17, 36, 72])
def test_any_number_of_faces(faces, name):
    curve = curve_of(np.arange(faces) * 360 / faces)
    fit = fit_curve(curve, name)
    angle = angles_of(curve)
    for values in (
        fit.evaluate(angle),
        fit.u_arcsec(angle),
        fit.interpolation_u_arcsec(angle),
        fit.leave_one_out_arcsec,
    ):
        assert np.isfinite(values).all()


@each_fit
@pytest.mark.parametrize("error_arcsec", [np.zeros(24), np.full(24, 1.5)])
def test_a_curve_without_shape(error_arcsec, name):
    for u in (None, np.full(24, 0.1)):
        fit = fit_curve(ErrorCurve(np.arange(24) * 15.0, error_arcsec, u), name)
        # The network falls 1e-6 short of a constant between its faces.
        assert np.abs(fit.evaluate(np.linspace(0, 360, 500)) - error_arcsec[0]).max() < 2e-5


@each_fit
@pytest.mark.parametrize(("faces", "key"), [(24, None), (23, "unequal")])
def test_a_smooth_error_is_found_between_the_faces(faces, key, name):
    angle = np.arange(24) * 15.0 if key is None else unequal_deg()
    truth = lambda deg: 2 * np.cos(np.radians(deg) - 0.4) + np.sin(np.radians(3 * deg))  # noqa: E731
    fit = fit_curve(ErrorCurve(angle, truth(angle), np.full(angle.size, 0.02)), name)
    everywhere = np.linspace(0, 360, 1000)
    limit = 0.02 if key is None else 0.15
    assert np.abs(fit.evaluate(everywhere) - truth(everywhere)).max() < limit


@each_fit
def test_interpolation_uncertainty_is_what_waves_of_any_phase_show(name):
    """Random phases of known harmonics: the fit's mean squared miss at each angle is the stated one."""
    angle = np.arange(24) * 15.0
    amplitude = np.array([1.0, 0.5, 0.8, 0.3])
    order = np.array([1, 3, 8, 10])
    random = np.random.default_rng(3)
    everywhere = np.linspace(0, 15, 31)
    curve = ErrorCurve(angle, np.cos(np.radians(np.outer(angle, order))) @ amplitude)
    fit = fit_curve(curve, name)
    phase = random.uniform(0, 2 * np.pi, (4000, 1, 4))
    at_faces = np.cos(np.radians(np.outer(angle, order)) + phase) @ amplitude
    truth = np.cos(np.radians(np.outer(everywhere, order)) + phase) @ amplitude
    missed = at_faces @ fit.weights(everywhere).T - truth
    stated = fit.interpolation_u_arcsec(everywhere)
    # The curve's own mean is taken for a mode of its own, and is next to nothing here.
    assert stated == pytest.approx(np.sqrt(np.mean(missed**2, axis=0)), rel=0.06, abs=2e-3)
    if name in INTERPOLATING:
        assert stated[[0, -1]] == pytest.approx(0, abs=1e-9)


def test_noise_that_is_stated_is_no_interpolation_uncertainty():
    random = np.random.default_rng(0)
    angle = np.arange(24) * 15.0
    bare, stated = [], []
    for _ in range(20):
        error = 0.1 * random.standard_normal(24)
        for found, u in ((bare, None), (stated, np.full(24, 0.1))):
            found.append(fit_curve(ErrorCurve(angle, error, u)).interpolation_u_arcsec(np.arange(0, 360, 0.5)).mean())
    assert np.mean(stated) < 0.7 * np.mean(bare)


def test_default_is_the_published_network(table_1):
    fit = fit_curve(table_1)
    network = RadialBasisNetwork.fit(table_1)
    angle = np.linspace(0, 360, 5000)
    assert (fit.name, fit.parameters) == ("rbf", {"spread_deg": 15.0, "ridge": 0.0})
    assert np.array_equal(fit.evaluate(angle), network.evaluate(angle))
    assert np.array_equal(fit.leave_one_out_arcsec, network.leave_one_out_arcsec)


@each_fit
def test_parameters_are_json_and_make_the_fit_again(table_1, name):
    fit = fit_curve(table_1, name)
    parameters = json.loads(json.dumps(fit.parameters))
    angle = np.linspace(0, 360, 777)
    assert np.array_equal(fit_curve(table_1, name, **parameters).evaluate(angle), fit.evaluate(angle))


def test_gaussian_process_is_that_of_scikit_learn():
    """With the same kernel and noise, values and nothing but the values agree with the library's own regressor."""
    from sklearn.gaussian_process import GaussianProcessRegressor
    from sklearn.gaussian_process.kernels import ConstantKernel, ExpSineSquared

    curve = CURVES["unequal"]
    fit = GaussianProcessFit(curve)
    half = np.radians(fit.parameters["half_distance_deg"])
    length = np.sin(half / 2) * np.sqrt(2 / np.log(2))
    kernel = ConstantKernel(fit.parameters["signal_arcsec"] ** 2) * ExpSineSquared(length, 360.0)
    process = GaussianProcessRegressor(kernel, alpha=curve.u_arcsec**2, optimizer=None)
    mean = curve.error_arcsec.mean()
    process.fit(curve.angle_deg[:, np.newaxis], curve.error_arcsec - mean)
    angle = angles_of(curve)
    assert process.predict(angle[:, np.newaxis]) + mean == pytest.approx(fit.evaluate(angle), abs=1e-9)


def test_gaussian_process_learns_scale_and_noise():
    """Curves drawn from a process of known half distance and noise: the medians of what is learnt are near them."""
    angle = np.arange(48) * 7.5
    half = np.radians(30)
    distance = np.radians(angle[:, np.newaxis] - angle)
    covariance = 4 * np.exp2(-((np.sin(distance / 2) / np.sin(half / 2)) ** 2))
    factor = np.linalg.cholesky(covariance + 1e-9 * np.eye(48))
    random = np.random.default_rng(11)
    learnt = []
    for _ in range(5):
        error = factor @ random.standard_normal(48) + 0.1 * random.standard_normal(48)
        learnt.append(list(GaussianProcessFit(ErrorCurve(angle, error)).parameters.values()))
    half_deg, signal, noise = np.median(learnt, axis=0)
    assert half_deg == pytest.approx(30, rel=0.1)
    assert signal == pytest.approx(2, rel=0.5)
    assert noise == pytest.approx(0.1, rel=0.25)


def test_fourier_takes_no_order_the_spacing_cannot_carry():
    # Three bunches of faces: they tell three numbers, not seventeen.
    bunched = np.sort(np.concatenate([start + np.arange(8) * 1e-3 for start in (0, 120, 240)]))
    curve = ErrorCurve(bunched, np.cos(np.radians(bunched)))
    assert fit_curve(curve, "fourier").parameters == {"order": 1}
    with pytest.raises(InputError, match="faces at these unequal distances cannot carry"):
        fit_curve(curve, "fourier", order=8)


def test_a_name_that_is_none(table_1):
    with pytest.raises(InputError, match="the fit 'lagrange' is not known, rbf, fourier, spline, gaussian-process are"):
        fit_curve(table_1, "lagrange")
