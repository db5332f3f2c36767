"""Which way to tip the polygon so that its axis stands along the encoder's, and which screw to turn how far.

The encoder's axis leans by psi from the polygon's towards the azimuth omega, so the polygon must be tipped that way:
its table goes down at omega and up on the far side, by psi times the distance from the axis.
"""

import math
import re
from dataclasses import dataclass

from arcref.calibration.stated_values import stated_number
from arcref.calibration.tower_tilt import ARCSEC_PER_RADIAN, TowerTilt
from arcref.run_file import RunFile

MOST_SCREWS = 12

CLEAR = 5.0
"""A tilt this many times its uncertainty is one: chance makes 2 in 10 000 without any, with 24 faces."""


@dataclass(frozen=True)
class AdjustingScrews:
    """Where the screws stand that tip the polygon: azimuths from face 1 towards face 2, radius, and pitch or None."""

    angle_deg: tuple[float, ...]
    radius_mm: float
    pitch_mm: float | None

    @classmethod
    def of_run(cls, run: RunFile) -> "AdjustingScrews | None":
        """What `run` states, None when it does not state angles and radius.

        Raises `InputError` for angles that are no numbers, repeat, or are too few to tip a table.
        """
        text = run.metadata.get("screw_angles_deg")
        radius, pitch = stated_number(run, "screw_radius_mm"), stated_number(run, "screw_pitch_mm")
        for key, value in (("screw_radius_mm", radius), ("screw_pitch_mm", pitch)):
            if value == 0:
                raise run.metadata_error(key, "0 mm, more than that was expected")
        if not text or radius is None:
            return None
        try:
            angles = tuple(float(part) for part in re.split(r"[;,\s]+", text.strip()))
        except ValueError:
            problem = f"{text!r} are no angles; degrees from face 1 were expected, as in '0 120 240'"
            raise run.metadata_error("screw_angles_deg", problem) from None
        apart = {round(angle % 360.0, 6) for angle in angles if math.isfinite(angle)}
        if not 2 <= len(angles) <= MOST_SCREWS or len(apart) != len(angles):
            problem = f"{text!r}, 2 to {MOST_SCREWS} different angles were expected"
            raise run.metadata_error("screw_angles_deg", problem)
        return cls(angles, radius, pitch)


@dataclass(frozen=True)
class ScrewTurn:
    """What to do at one screw: by how much the table must rise there (negative: sink), and the turn that does it."""

    number: int
    angle_deg: float
    rise_um: float
    turn_deg: float | None


def rise_um_per_100_mm(tilt: TowerTilt) -> float:
    """How much the table must sink at omega, and rise on the far side, 100 mm from the axis."""
    return 1e5 * tilt.psi_arcsec / ARCSEC_PER_RADIAN


def screw_turns(tilt: TowerTilt, screws: AdjustingScrews) -> tuple[ScrewTurn, ...]:
    """The turn of each screw that takes the tilt away and leaves the table's middle at its height.

    The same rise added to every screw changes no tilt: to leave one screw alone, take its rise off all of them.
    """
    turns = []
    for number, angle_deg in enumerate(screws.angle_deg, 1):
        along_tilt = math.cos(math.radians(angle_deg - tilt.omega_deg))
        rise_um = -1e3 * screws.radius_mm * tilt.psi_arcsec / ARCSEC_PER_RADIAN * along_tilt
        turn_deg = None if screws.pitch_mm is None else 360.0 * rise_um / (1e3 * screws.pitch_mm)
        turns.append(ScrewTurn(number, angle_deg, rise_um, turn_deg))
    return tuple(turns)


def adjustment_sentences(tilt: TowerTilt, screws: AdjustingScrews | None, faces: int) -> list[str]:
    """Where to turn, which way, how much; for the report and the terminal."""
    high = 1 + round(tilt.omega_deg % 360.0 / (360.0 / faces)) % faces
    far = 1 + round((tilt.omega_deg + 180.0) % 360.0 / (360.0 / faces)) % faces
    sentences = [
        f"Tip the polygon towards {round(tilt.omega_deg, 1) % 360.0:.1f} deg from face 1 (nearest face {high}): lower "
        f"that side, or raise the far one (nearest face {far}), by "
        f"{rise_um_per_100_mm(tilt):.1f} um per 100 mm from the axis."
    ]
    if math.isnan(tilt.u_psi_arcsec) or tilt.psi_arcsec < CLEAR * tilt.u_psi_arcsec:
        sentences.append("The tilt is not clear of its uncertainty: there is nothing to turn.")
        return sentences
    if screws is None:
        sentences.append(
            "For the turn of each screw, state screw_angles_deg (from face 1 towards face 2), screw_radius_mm and "
            "screw_pitch_mm in the run file."
        )
        return sentences
    for turn in screw_turns(tilt, screws):
        sentences.append(_screw_sentence(turn))
    sentences.append(
        "The same rise on every screw changes no tilt; to leave one screw alone, take its rise off all of them. "
        "Driven in means the way that raises the table: clockwise for a right-hand thread standing on its tip."
    )
    return sentences


def _screw_sentence(turn: ScrewTurn) -> str:
    where = f"Screw {turn.number} (at {turn.angle_deg:g} deg)"
    way = "raise" if turn.rise_um > 0 else "lower"
    sentence = f"{where}: {way} by {abs(turn.rise_um):.1f} um"
    if turn.turn_deg is None:
        return sentence + "; with screw_pitch_mm stated this becomes a turn."
    return sentence + f", drive it {'in' if turn.rise_um > 0 else 'out'} by {abs(turn.turn_deg):.1f} deg of turn."
