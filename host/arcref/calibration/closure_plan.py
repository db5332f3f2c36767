"""What a closure run with chosen settings would separate, said before anybody takes a reading."""

import math
from dataclasses import dataclass
from itertools import combinations, islice

import numpy as np

from arcref.calibration.closure_design import SettingsDesign
from arcref.calibration.closure_run import (
    FACE,
    LARGEST_SETTING,
    POSITION,
    ROUND,
    SETTING,
    SMALLEST_STEP_DEG,
    X,
    read_settings,
    stated_step_deg,
)
from arcref.calibration.metadata_key import CLOSURE
from arcref.calibration.metadata_keys import known_keys
from arcref.calibration.polygon_metadata import FEWEST_FACES, MOST_FACES, stated_faces
from arcref.input_error import InputError
from arcref.run_file import read_run_file

WEAK = 2.0
"""Orders with this much more noise than in a whole set are named."""

_CHOICES_LOOKED_AT = 40_000


@dataclass(frozen=True, eq=False)
class ClosurePlan:
    """Settings (numbers from 1) of a polygon, `step_deg` apart, and which faces are read at each."""

    faces: int
    settings: tuple[int, ...]
    step_deg: float
    design: SettingsDesign

    @classmethod
    def of(cls, faces: int, settings: tuple[int, ...], step_deg: float) -> "ClosurePlan":
        """The plan. Raises `InputError` for one that cannot be."""
        if not FEWEST_FACES <= faces <= MOST_FACES:
            raise InputError(f"{faces} faces, {FEWEST_FACES} .. {MOST_FACES} were expected")
        if not SMALLEST_STEP_DEG <= abs(step_deg) < 360.0:
            raise InputError(f"a step of {step_deg:g} deg, {SMALLEST_STEP_DEG:g} to less than 360 deg was expected")
        if len(set(settings)) < 2 or len(set(settings)) != len(settings):
            raise InputError("at least two different settings of the polygon were expected: one separates nothing")
        if min(settings) < 1 or max(settings) > LARGEST_SETTING:
            raise InputError(f"settings are numbered from 1 to {LARGEST_SETTING} at most")
        setting, face = np.meshgrid(settings, np.arange(faces), indexing="ij")
        try:
            return cls.of_readings(faces, step_deg, setting.ravel(), face.ravel())
        except ValueError as error:
            raise InputError(f"{faces} faces, {len(settings)} settings, {step_deg:g} deg apart: {error}") from None

    @classmethod
    def of_readings(cls, faces: int, step_deg: float, setting, face, round_=None) -> "ClosurePlan":
        """The plan of these readings, as `SettingsDesign.of` takes them. Raises `ValueError` as that does."""
        design = SettingsDesign.of(faces, step_deg, setting, face, round_)
        _ = design.lost
        return cls(faces, tuple(int(number) for number in np.unique(setting)), step_deg, design)

    @property
    def u_per_reading(self) -> float:
        """Standard uncertainty of the encoder's error, rms over the positions, for one reading's of 1."""
        p = len(self.design.position_deg)
        return float(np.sqrt(np.mean(np.diag(self.design.covariance)[:p])))

    @property
    def largest_factor(self) -> float:
        """The largest noise factor, infinite when an order is lost."""
        factor = self.design.noise_factor
        return math.inf if self.design.lost_orders else float(factor.max())

    def better(self) -> "ClosurePlan | None":
        """As many settings of the same polygon that separate more, or None when hardly any would.

        At the face spacing; all choices are tried where there are few, else a fixed selection of them.
        """
        count = len(self.settings)
        if count > self.faces:
            return None
        choices = _choices(self.faces, count)
        turns = np.exp(2j * np.pi * np.outer(np.arange(1, self.faces // 2 + 1), np.arange(self.faces)) / self.faces)
        together = np.abs(turns[:, choices].sum(axis=2)).max(axis=0)  # [choices]: of the order they tell apart least
        best = choices[int(np.argmin(np.round(together, 9)))]
        plan = ClosurePlan.of(self.faces, tuple(int(place) + 1 for place in best), 360.0 / self.faces)
        return plan if plan.largest_factor < 0.9 * self.largest_factor else None


def read_plan(path) -> ClosurePlan:
    """The plan of a run file, with or without its readings.

    Raises `InputError` as `read_run_file` does, and for a plan that cannot be.
    """
    run = read_run_file(path, (SETTING, FACE), (ROUND, POSITION, X), known_keys(CLOSURE))
    faces, step_deg = stated_faces(run), stated_step_deg(run)
    setting, face, round_ = read_settings(run, faces)
    if len(np.unique(setting)) < 2:
        raise InputError.at(run.path, "at least two settings of the polygon were expected: one separates nothing")
    try:
        return ClosurePlan.of_readings(faces, step_deg, setting, face, round_)
    except ValueError as error:
        raise run.metadata_error("setting_step_deg", f"{step_deg:g} deg: {error}") from None


def plan_sentences(design: SettingsDesign) -> tuple[str, ...]:
    """What these settings separate and what they lose, in words; of a plan and of a run alike."""
    sentences = []
    if design.lost_orders:
        other = "the mountings of settings that share no position" if design.lost_to_mountings else "the faces"
        if design.lost_to_mountings and design.lost_from_faces.any():
            other = "the faces, nor from the mountings of settings that share no position"
        sentences.append(
            f"Lost: order{_plural(design.lost_orders)} {_listed(design.lost_orders)} of the encoder's error cannot be "
            f"told from {other}. {'They are' if len(design.lost_orders) > 1 else 'It is'} left out of the curve."
        )
    else:
        sentences.append("Every order that these positions show is separated from the faces.")
    factor = np.nan_to_num(design.noise_factor)
    weak = tuple(int(order) for order in design.orders[factor > WEAK])
    if weak:
        worst = int(design.orders[int(np.argmax(factor))])
        largest = f"{factor.max():.2f} times the noise of a whole set"
        sentences.append(
            f"Weak: order {worst} with {largest}."
            if len(weak) == 1
            else f"Weak: orders {_listed(weak)} with more than {WEAK:g} times, order {worst} with {largest}."
        )
    sentences.append(
        f"An error of the encoder of order higher than {design.orders[-1]} looks like one of these, whatever the "
        "settings: positions in between would tell."
    )
    return tuple(sentences)


def _choices(faces: int, count: int) -> np.ndarray:
    """int[choices, count]: places of the settings on the faces' net, the first at 0."""
    others = range(1, faces)
    if math.comb(faces - 1, count - 1) <= _CHOICES_LOOKED_AT:
        found = [(0, *choice) for choice in islice(combinations(others, count - 1), _CHOICES_LOOKED_AT)]
        return np.array(found)
    random = np.random.default_rng(faces * 1000 + count)
    rows = random.random((_CHOICES_LOOKED_AT // 8, faces - 1)).argsort(axis=1)[:, : count - 1] + 1
    return np.hstack([np.zeros((len(rows), 1), int), np.sort(rows, axis=1)])


def _plural(orders: tuple[int, ...]) -> str:
    return "s" if len(orders) > 1 else ""


def _listed(orders: tuple[int, ...], most: int = 16) -> str:
    shown = ", ".join(map(str, orders[:most]))
    return shown if len(orders) <= most else f"{shown} ... ({len(orders)} in all)"
