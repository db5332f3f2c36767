"""Mean, standard deviation and span of a set of errors."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class ErrorStatistics:
    """Statistics of `n` errors in arcsec.

    `sigma_arcsec` is Bessel's: the root of the squared deviations from the mean over n - 1, Yu Hai et al. 2015
    equation (8). `peak_to_peak_arcsec` is the largest minus the smallest error.
    """

    n: int
    mean_arcsec: float
    sigma_arcsec: float
    peak_to_peak_arcsec: float

    @classmethod
    def of(cls, error_arcsec) -> "ErrorStatistics":
        """The statistics of `error_arcsec`, shape (n,). Raises `ValueError` for fewer than two errors."""
        error_arcsec = np.asarray(error_arcsec, float)
        if error_arcsec.ndim != 1 or error_arcsec.size < 2:
            raise ValueError(f"at least two errors in one row are needed, shape {error_arcsec.shape} was given")
        return cls(
            error_arcsec.size,
            float(error_arcsec.mean()),
            float(error_arcsec.std(ddof=1)),
            float(np.ptp(error_arcsec)),
        )
