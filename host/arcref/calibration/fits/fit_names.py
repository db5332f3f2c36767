"""The fits by name."""

from importlib import import_module

from arcref.calibration.fits.curve_fit import FittedCurve
from arcref.error_curve import ErrorCurve
from arcref.input_error import InputError

_FITS = {
    "rbf": "radial_basis_fit:RadialBasisFit",
    "fourier": "fourier_fit:FourierFit",
    "spline": "spline_fit:SplineFit",
    "gaussian-process": "gaussian_process_fit:GaussianProcessFit",
}

FIT_NAMES = tuple(_FITS)
"""Names of the fits, for options; the default first."""

DEFAULT_FIT = FIT_NAMES[0]


def fit_curve(curve: ErrorCurve, name: str = DEFAULT_FIT, **parameters) -> FittedCurve:
    """Fit `curve`. `parameters` are those of the fit: what is left out takes its default or is learnt.

    Raises `InputError` for a name that is none, and as the fit itself does.
    """
    if name not in _FITS:
        raise InputError(f"the fit {name!r} is not known, {', '.join(FIT_NAMES)} are")
    module, _, kind = _FITS[name].partition(":")
    # A fit is imported when it is used: the Gaussian process brings scikit-learn, which takes a second.
    fit = getattr(import_module(f"arcref.calibration.fits.{module}"), kind)
    return fit(curve, **parameters)
