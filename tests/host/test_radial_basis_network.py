import numpy as np
import pytest

from arcref.error_curve import ErrorCurve
from arcref.input_error import InputError
from arcref.radial_basis_network import RadialBasisNetwork, gaussian


def sum_over_images(difference_deg, spread_deg):
    """The wrapped Gaussian by its definition: every image from -3 to 3, nothing left out."""
    return sum(np.exp(-np.log(2) * ((difference_deg + 360 * k) / spread_deg) ** 2) for k in range(-3, 4))


@pytest.mark.parametrize("spread_deg", [1, 10, 15, 22.5, 30, 35, 45, 60])
def test_wrapped_kernel_is_the_sum_over_images(spread_deg):
    difference = np.linspace(-180, 180, 3601)
    expected = sum_over_images(difference, spread_deg)
    assert np.abs(gaussian(difference, spread_deg) - expected).max() < 1e-14
    assert np.abs(gaussian(difference + 720, spread_deg) - expected).max() < 1e-13


@pytest.mark.parametrize("wrapped", [True, False])
def test_kernel_is_half_at_the_spread(wrapped):
    assert gaussian(0.0, 15.0, wrapped) == pytest.approx(1, abs=1e-15)
    assert gaussian(15.0, 15.0, wrapped) == pytest.approx(0.5, abs=1e-15)


def test_meets_every_face(table_1):
    network = RadialBasisNetwork.fit(table_1)
    assert network.spread_deg == 15
    assert np.abs(network.evaluate(table_1.angle_deg) - table_1.error_arcsec).max() < 1e-13
    assert np.abs(network.residual_arcsec).max() < 1e-13


def test_neither_jump_nor_kink_at_the_seam(table_1):
    network = RadialBasisNetwork.fit(table_1)
    around = network.evaluate(np.array([-1e-4, 0.0, 1e-4]) + 360)
    assert np.abs(np.diff(around)).max() < 1e-4
    assert abs(np.diff(around, 2)[0]) < 1e-8
    assert network.evaluate(725.0) == pytest.approx(network.evaluate(5.0), abs=1e-12)


def test_shapes(table_1):
    network = RadialBasisNetwork.fit(table_1)
    assert network.evaluate(3.0).shape == ()
    assert network.evaluate(np.zeros((2, 3))).shape == (2, 3)
    many = np.linspace(0, 360, 40_000)
    one_by_one = np.array([network.evaluate(angle) for angle in many[::4000]])
    assert np.allclose(network.evaluate(many)[::4000], one_by_one, rtol=0, atol=1e-13)


def test_the_origin_of_the_angles_does_not_matter(table_1):
    turned = ErrorCurve(table_1.angle_deg - 200.0, table_1.error_arcsec)
    angle = np.linspace(0, 360, 500)
    expected = RadialBasisNetwork.fit(table_1).evaluate(angle)
    assert np.allclose(RadialBasisNetwork.fit(turned).evaluate(angle - 200), expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize("ridge", [0.0, 0.1, 3.0])
@pytest.mark.parametrize("wrapped", [True, False])
@pytest.mark.parametrize("spread_deg", [5, 15, 22.5])
def test_leave_one_out_in_closed_form_is_that_of_refitting(table_1, spread_deg, wrapped, ridge):
    network = RadialBasisNetwork.fit(table_1, spread_deg, ridge, wrapped)
    for left_out, closed in enumerate(network.leave_one_out_arcsec):
        others = np.delete(np.arange(24), left_out)
        curve = ErrorCurve(table_1.angle_deg[others], table_1.error_arcsec[others])
        refitted = RadialBasisNetwork.fit(curve, spread_deg, ridge, wrapped)
        foretold = refitted.evaluate(table_1.angle_deg[left_out])
        assert closed == pytest.approx(table_1.error_arcsec[left_out] - foretold, abs=1e-9)


def test_ridge_smooths(table_1):
    ridged = RadialBasisNetwork.fit(table_1, ridge=0.5)
    assert 0.05 < np.abs(ridged.residual_arcsec).max() < 2
    assert np.abs(ridged.weight_arcsec).max() < np.abs(RadialBasisNetwork.fit(table_1).weight_arcsec).max()
    assert ridged.condition_number < RadialBasisNetwork.fit(table_1).condition_number


@pytest.mark.parametrize("faces", [3, 8, 24, 72, 360])
def test_the_default_spread_suits_any_number_of_faces(faces):
    angle = np.arange(faces) * 360 / faces
    network = RadialBasisNetwork.fit(ErrorCurve(angle, np.cos(np.radians(angle))))
    assert network.condition_number < 20
    if faces >= 24:
        everywhere = np.linspace(0, 360, 1000)
        assert np.abs(network.evaluate(everywhere) - np.cos(np.radians(everywhere))).max() < 2e-3


@pytest.mark.parametrize("spread_deg", [45, 60, 90, 180, 200, 300, 1000, 1e6, 1e300])
def test_a_badly_conditioned_spread_is_refused(table_1, spread_deg):
    with pytest.raises(InputError) as caught:
        RadialBasisNetwork.fit(table_1, spread_deg)
    assert f"a spread c of {spread_deg:g} deg is badly conditioned (condition number " in str(caught.value)
    assert str(caught.value).endswith("the limit is 1e+09); with faces 15 deg apart, 10 to 22.5 deg is usable")


@pytest.mark.parametrize("spread_deg", [0.0, -1.0, float("nan"), float("inf")])
def test_a_spread_that_is_none(table_1, spread_deg):
    with pytest.raises(InputError, match="the spread is .* a positive number was expected"):
        RadialBasisNetwork.fit(table_1, spread_deg)


@pytest.mark.parametrize("ridge", [-0.1, float("nan"), float("inf")])
def test_a_ridge_that_is_none(table_1, ridge):
    with pytest.raises(InputError, match="the ridge is"):
        RadialBasisNetwork.fit(table_1, ridge=ridge)
