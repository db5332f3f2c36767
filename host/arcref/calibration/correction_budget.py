"""What the correction itself adds to the uncertainty of a corrected angle, whatever method measured the curve."""

import math

import numpy as np

from arcref.angle import ARCSEC_PER_COUNT, LINES_PER_TURN
from arcref.calibration.fit_transfer import FitTransfer, line_middles_deg
from arcref.calibration.stated_values import stated_number
from arcref.calibration.uncertainty_budget import Contribution, MissingInput
from arcref.run_file import RunFile

HALF_COUNT_U = 1 / math.sqrt(12)
"""Standard uncertainty, in counts, of a value rounded to the whole count: rectangular, half a count either way."""

INTERPOLATION = "interpolation, not seen by the faces"
"""Name of the contribution that a second table takes away."""

INTERPOLATION_KEYS = ("u_interpolation_arcsec", "interpolation_amplitude_arcsec")


def correction_contributions(
    run: RunFile, fitted, line_phasor=None
) -> tuple[tuple[Contribution, ...], tuple[MissingInput, ...]]:
    """Contributions of fit, ROM and reading, and what is missing for them.

    `fitted`: the curve that goes into the ROM. `line_phasor`, complex128[faces]: exp(i phase) of the place within its
    grating line at which each face was read (the mean over its readings); None takes it from the curve's angles.
    """
    angle_deg = line_middles_deg(fitted)
    fit_u = _rms(fitted.interpolation_u_arcsec(angle_deg))
    slope = _rms(np.gradient(fitted.evaluate(angle_deg), angle_deg)) if angle_deg.size > 1 else 0.0
    contributions = [
        Contribution(
            "fit between the faces", "B", "normal", fit_u, "arcsec", 1.0,
            f"{fitted.title}: what it makes of the curve's own harmonics between the faces",
        ),
        Contribution(
            "rounding of the ROM", "B", "rectangular", HALF_COUNT_U, "count", ARCSEC_PER_COUNT,
            "the correction is a whole count, half a count either way",
        ),
        Contribution(
            "one ROM entry a grating line", "B", "rectangular", 360 / LINES_PER_TURN / math.sqrt(12), "deg", slope,
            "slope of the curve, rms over the turn, over one line's width",
        ),
        Contribution(
            "resolution of the reading", "B", "rectangular", HALF_COUNT_U, "count", ARCSEC_PER_COUNT,
            "a reading is a whole count, half a count either way",
        ),
    ]  # fmt: skip
    u_interpolation = interpolation_u_arcsec(run)
    if u_interpolation is None:
        missing = (MissingInput("error within a grating line (interpolation)", INTERPOLATION_KEYS[0]),)
        return tuple(contributions), missing
    burnt_in = FitTransfer(fitted.weights(angle_deg)).of_shape(
        line_phasor_of(fitted.curve.angle_deg) if line_phasor is None else line_phasor
    )
    contributions.append(
        Contribution(
            INTERPOLATION, "B", "arcsine", u_interpolation, "arcsec", math.hypot(1, burnt_in),
            f"stated; once in the reading, and {burnt_in:.2f} times in the ROM, where the faces put it as a false wave",
        )
    )  # fmt: skip
    return tuple(contributions), ()


def interpolation_u_arcsec(run: RunFile) -> float | None:
    """Standard uncertainty of the error within a line as the run states it; an amplitude is that of a sine wave."""
    u, amplitude = (stated_number(run, key) for key in INTERPOLATION_KEYS)
    if u is not None and amplitude is not None:
        raise run.metadata_error(INTERPOLATION_KEYS[1], f"{INTERPOLATION_KEYS[0]} stands here too, one was expected")
    return u if amplitude is None else amplitude / math.sqrt(2)


def line_phasor_of(position_deg) -> np.ndarray:
    """exp(i phase) within the grating line at each position in degrees of the turn."""
    return np.exp(1j * np.radians(np.mod(np.asarray(position_deg) * LINES_PER_TURN, 360.0)))


def _rms(values) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
