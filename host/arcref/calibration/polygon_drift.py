"""What drift within the rounds and the direction of turning leave in the reduced errors of a polygon run."""

import math

import numpy as np

from arcref.calibration.fit_transfer import FitTransfer
from arcref.calibration.polygon_inputs import PolygonInputs


def drift_shape_arcsec(inputs: PolygonInputs, transfer: FitTransfer) -> np.ndarray:
    """What steady drift within the rounds does to the reduced errors, float64[faces].

    The closing error of a series is spread evenly over its readings in the order they were taken; a series that was not
    closed counts as one without drift. What the scatter of the readings alone would do is taken off in the squares.
    """
    closed = np.isfinite(inputs.closing_error_arcsec)
    weight = inputs.weight[closed]
    ramps = inputs.turn_order[closed]
    shape = (weight * inputs.closing_error_arcsec[closed]) @ ramps
    whole = transfer.of_shape(shape)
    if whole == 0 or inputs.repeatability_arcsec is None:
        return shape
    parts = sum((own * transfer.of_shape(ramp)) ** 2 for own, ramp in zip(weight, ramps, strict=True))
    scatter = 2 * inputs.repeatability_arcsec**2 * parts
    return shape * math.sqrt(max(0.0, 1 - scatter / whole**2))


def return_half_arcsec(inputs: PolygonInputs) -> np.ndarray:
    """Half the return error at each face, float64[faces]: zeros when one direction alone was read.

    What the scatter of the readings alone would do is taken off in the squares: off the part that changes over the
    turn that of single readings, off the mean that of the means of the series, which drift from series to series.
    """
    if inputs.return_error_arcsec is None:
        return np.zeros(inputs.faces)
    half = inputs.return_error_arcsec / 2
    mean = half.mean()
    change = half - mean
    groups = [inputs.series_constant_arcsec[np.array(inputs.direction) == way] for way in (1, -1)]
    each_way = sum(1 / group.size for group in groups)
    if inputs.repeatability_arcsec is not None:
        change = _beyond(change, inputs.repeatability_arcsec**2 / 4 * each_way * (1 - 1 / inputs.faces))
    freedom = sum(group.size - 1 for group in groups)
    if freedom:
        variance = sum(((group - group.mean()) ** 2).sum() for group in groups) / freedom
        mean = _beyond(np.array([mean]), variance / 4 * each_way)[0]
    return mean + change


def _beyond(values: np.ndarray, variance: float) -> np.ndarray:
    """`values`, scaled so that their mean square is less by `variance`, and not below zero."""
    power = float(np.mean(values**2))
    return values * math.sqrt(max(0.0, 1 - variance / power)) if power else values
