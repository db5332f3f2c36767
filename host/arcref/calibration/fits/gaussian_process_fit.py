"""A Gaussian process with a periodic kernel as a fit, its kernel learnt by scikit-learn.

The kernel is that of MacKay (1998), `variance exp(-2 sin^2(distance / 2) / length^2)`; variance and length are those of
the largest marginal likelihood. The noise is the curve's stated uncertainty; when it states none it is learnt as well.
"""

import warnings

import numpy as np

from arcref.calibration.fits.curve_fit import FittedCurve
from arcref.error_curve import ErrorCurve

SHORTEST_LENGTH_SPACINGS = 1.0
"""Least distance, in face spacings, at which the kernel falls to a half: the default spread of the RBF network.

A strong wave of three faces or so a period looks to the likelihood like errors that know nothing of each other; with a
shorter kernel the process then falls back to the mean between the faces.
"""

LONGEST_HALF_DEG = 120.0
"""Largest distance at which the kernel falls to a half. Only a constant would ask for more."""

_NOISE_FLOOR = 1e-6  # of the faces' variance: keeps the equations solvable when the stated noise is next to nothing


class GaussianProcessFit(FittedCurve):
    """The mean of the process given the faces, about their mean.

    `half_distance_deg` is where the kernel falls to a half, comparable with the spread of the RBF network.
    """

    name = "gaussian-process"
    title = "Gaussian process"

    def __init__(
        self,
        curve: ErrorCurve,
        half_distance_deg: float | None = None,
        signal_arcsec: float | None = None,
        noise_arcsec: float | None = None,
    ):
        """Fit. What is not given is learnt: the kernel's half distance, its standard deviation, and the noise's."""
        if curve.u_arcsec is not None:
            stated = curve.u_arcsec**2
        else:
            stated = None if noise_arcsec is None else np.full(curve.angle_deg.size, noise_arcsec**2)
        if half_distance_deg is None:
            half_distance_deg, signal_arcsec, noise_arcsec = _learn(curve, stated)
            stated = np.full(curve.angle_deg.size, noise_arcsec**2) if stated is None else stated
        parameters = {"half_distance_deg": half_distance_deg, "signal_arcsec": signal_arcsec}
        if curve.u_arcsec is None:
            parameters["noise_arcsec"] = noise_arcsec
        super().__init__(curve, parameters)
        noise = np.maximum(stated, _NOISE_FLOOR * signal_arcsec**2)
        faces = self._kernel(curve.angle_deg) + np.diag(noise)
        # Weights of the errors about their mean, and of the mean: k C^-1 (1 - 11'/n) + 1'/n.
        inverse = np.linalg.inv(faces)
        self._inverse = inverse - inverse.mean(axis=1, keepdims=True)

    def _kernel(self, angle_deg: np.ndarray) -> np.ndarray:
        distance = np.radians(angle_deg[:, np.newaxis] - self.curve.angle_deg)
        half = np.radians(self.parameters["half_distance_deg"])
        # One half where sin(distance / 2) is that of the half distance.
        ratio = np.sin(distance / 2) / np.sin(half / 2)
        return self.parameters["signal_arcsec"] ** 2 * np.exp2(-(ratio**2))

    def _weights(self, angle_deg):
        return self._kernel(angle_deg) @ self._inverse + 1.0 / self.curve.angle_deg.size

    def _refitted(self, curve):
        return GaussianProcessFit(curve, **self.parameters)


def _learn(curve: ErrorCurve, noise_arcsec2: np.ndarray | None) -> tuple[float, float, float]:
    """Half distance in degrees, standard deviation of the signal and of the noise, of the largest likelihood."""
    # Imported here: it takes a second, and most runs learn nothing.
    from sklearn.exceptions import ConvergenceWarning
    from sklearn.gaussian_process import GaussianProcessRegressor
    from sklearn.gaussian_process.kernels import ConstantKernel, ExpSineSquared, WhiteKernel

    error = curve.error_arcsec - curve.error_arcsec.mean()
    scale = float(np.sqrt(np.mean(error**2)))
    shortest = min(SHORTEST_LENGTH_SPACINGS * curve.spacing_deg, 0.9 * LONGEST_HALF_DEG)
    if scale == 0.0:
        return shortest, 1.0, 0.0
    lengths = _length(shortest), _length(LONGEST_HALF_DEG)
    kernel = ConstantKernel(1.0, (1e-2, 1e2)) * ExpSineSquared(np.sqrt(np.prod(lengths)), 360.0, lengths, "fixed")
    if noise_arcsec2 is None:
        kernel, noise = kernel + WhiteKernel(0.05, (_NOISE_FLOOR, 1.0)), 1e-10
    else:
        noise = np.maximum(noise_arcsec2 / scale**2, _NOISE_FLOOR)
    process = GaussianProcessRegressor(kernel, alpha=noise, n_restarts_optimizer=2, random_state=0)
    with warnings.catch_warnings():
        # A bound is an answer here: the shortest length says that faces know nothing of their neighbours.
        warnings.simplefilter("ignore", ConvergenceWarning)
        process.fit(curve.angle_deg[:, np.newaxis], error / scale)
    learnt = process.kernel_.get_params()
    prefix = "k1__" if noise_arcsec2 is None else ""
    half_deg = np.degrees(2 * np.arcsin(min(1.0, learnt[f"{prefix}k2__length_scale"] * np.sqrt(np.log(2) / 2))))
    signal = scale * np.sqrt(learnt[f"{prefix}k1__constant_value"])
    learnt_noise = scale * np.sqrt(learnt["k2__noise_level"]) if noise_arcsec2 is None else 0.0
    # Rounded, so that a provenance can name them whole: the fit made again from it is the same.
    return tuple(float(f"{value:.4g}") for value in (half_deg, signal, learnt_noise))


def _length(half_distance_deg: float) -> float:
    """Length of scikit-learn's kernel that falls to a half at this distance."""
    return float(np.sin(np.radians(half_distance_deg) / 2) * np.sqrt(2 / np.log(2)))
