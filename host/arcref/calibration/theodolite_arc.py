"""How long an arc must be: the uncertainty of the angle for arcs of any length, before or after the readings."""

import math

import numpy as np

from arcref.calibration.theodolite_model import MirrorGeometry
from arcref.calibration.theodolite_solution import ArcReadings, ArcSolution

LONGEST_ARC_DEG = 340.0

_MOST_PLACES = 200


def arc_u_arcsec(
    geometry: MirrorGeometry,
    start_deg: float,
    arc_deg: float,
    places: int,
    u_zenith_arcsec: float,
    u_azimuth_arcsec: float,
    rounds: int = 1,
) -> np.ndarray:
    """Standard uncertainty of the error at each of `places` over an arc, about its mean, float64[places].

    `start_deg`: theta at which the arc begins; from parameters and azimuths, nothing else.
    """
    theta = np.radians(np.linspace(start_deg, start_deg + arc_deg, places))
    nothing = np.zeros(places)
    readings = ArcReadings(
        theta, geometry.azimuth_rad(theta), geometry.elevation_rad(theta), np.arange(places), nothing.astype(int)
    )
    solution = ArcSolution(readings, geometry, geometry, np.zeros(1), theta, nothing, nothing, nothing)
    covariance = solution.sensitivity().error_covariance(u_zenith_arcsec, u_azimuth_arcsec) / rounds
    return np.sqrt(np.maximum(np.diag(covariance), 0.0))


def shortest_arc_deg(
    largest_u_arcsec: float, geometry: MirrorGeometry, start_deg: float, places: int, *noise
) -> float | None:
    """The arc from `start_deg` on, with as many places, whose worst uncertainty is as small as asked; None if none is.

    `noise`: u of zenith and azimuth in arcsec, and the number of rounds. To a hundredth of its length.
    """
    places = min(places, _MOST_PLACES)

    def suffices(arc_deg: float) -> bool:
        return bool(arc_u_arcsec(geometry, start_deg, arc_deg, places, *noise).max() <= largest_u_arcsec)

    short, long = 0.5, LONGEST_ARC_DEG
    if not suffices(long):
        return None
    while long > 1.01 * short:
        middle = math.sqrt(short * long)
        short, long = (short, middle) if suffices(middle) else (middle, long)
    return long
