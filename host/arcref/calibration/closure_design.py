"""Which unknowns each reading of a closure run holds, and what the chosen settings cannot tell apart.

Face f met at setting k reads `encoder error at the position + face deviation + mounting of that series`. A series is
one setting in one round: its mounting is unknown, because nobody knows how the polygon was put down. Two constants are
never seen, whatever is read: the mean of the encoder's errors and the mean of the face deviations. Both are set to
zero; that is the datum. Everything else is separated, or lost, by the choice of settings.

For a whole set of positions the order h of both errors is separated unless exp(2 pi i h k step / 360) is the same for
all settings k; `SettingsDesign` finds this from the readings as they are, with readings missing or steps of any size.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

SAME_POSITION_DEG = 0.01
"""Nominal positions closer than this are one: a step written with a few decimals, 51.4286 for 360/7."""

LARGEST_UNKNOWNS = 1600
"""More unknowns than a polygon of 72 faces at any sensible step has; the eigenvalues would take minutes."""

# Eigenvalues of the normal equations are of the order of the readings at a position; those lost are 0 but for rounding.
_SINGULAR = 1e-9

_LOST_FRACTION = 1e-6

_UNTIED = 1e-6


@dataclass(frozen=True, eq=False)
class SettingsDesign:
    """The unknowns of a closure run.

    `position_deg`: float64[p], nominal encoder positions that were met, increasing from 0; `faces`: int[f], the faces
    that were met (from 0); `position`, `face`, `series`: int[n], which of them each reading holds.
    """

    position_deg: np.ndarray
    faces: np.ndarray
    position: np.ndarray
    face: np.ndarray
    series: np.ndarray

    @classmethod
    def of(cls, faces: int, step_deg: float, setting, face, round_=None) -> "SettingsDesign":
        """The design of readings `setting` (from 1) and `face` (from 0), int[n] each, in rounds `round_`, int[n].

        Raises `ValueError` when the step makes positions that are neither the same nor apart.
        """
        setting, face = np.asarray(setting), np.asarray(face)
        round_ = np.zeros_like(setting) if round_ is None else np.asarray(round_)
        nominal = np.mod(nominal_position_deg(faces, step_deg, setting, face), 360.0)
        position_deg, position = _same_positions(nominal)
        met, face = np.unique(face, return_inverse=True)
        series = np.unique(np.stack([round_, setting]), axis=1, return_inverse=True)[1]
        return cls(position_deg, met, position, face.ravel(), series.ravel())

    @property
    def readings(self) -> int:
        """Number of readings."""
        return len(self.position)

    @property
    def series_count(self) -> int:
        """Number of series: settings times rounds."""
        return int(self.series.max()) + 1

    @property
    def unknowns(self) -> int:
        """Encoder errors, face deviations and mountings together, the two constants of the datum among them."""
        return len(self.position_deg) + len(self.faces) + self.series_count

    @cached_property
    def matrix(self) -> np.ndarray:
        """float64[n, unknowns]: encoder errors first, then face deviations, then mountings."""
        matrix = np.zeros((self.readings, self.unknowns))
        rows = np.arange(self.readings)
        p, f = len(self.position_deg), len(self.faces)
        for column in (self.position, p + self.face, p + f + self.series):
            matrix[rows, column] = 1.0
        return matrix

    @cached_property
    def lost(self) -> np.ndarray:
        """float64[unknowns, d]: changes of the unknowns that leave every reading as it is and keep both means zero.

        d = 0 when all is separated. Raises `ValueError` above `LARGEST_UNKNOWNS`.
        """
        if self.unknowns > LARGEST_UNKNOWNS:
            problem = (
                f"{len(self.position_deg)} encoder positions, {len(self.faces)} faces and {self.series_count} "
                f"mountings are unknown, more than {LARGEST_UNKNOWNS} together"
            )
            raise ValueError(problem)
        means = self._means
        normal = self.matrix.T @ self.matrix + means.T @ means
        value, vector = np.linalg.eigh(normal)
        return vector[:, value < _SINGULAR * value[-1]]

    @property
    def rank(self) -> int:
        """Number of unknowns that the readings determine."""
        return self.unknowns - 2 - self.lost.shape[1]

    @property
    def degrees_of_freedom(self) -> int:
        """Readings beyond those that the unknowns need."""
        return self.readings - self.rank

    @cached_property
    def estimator(self) -> np.ndarray:
        """float64[unknowns, n]: least squares, `unknowns = estimator @ readings`.

        Both means are zero, and what was lost is given to the faces: the encoder's curve has no part along it.
        """
        p = len(self.position_deg)
        constraints = np.vstack([self._means, np.zeros((self.lost.shape[1], self.unknowns))])
        constraints[2:, :p] = self.lost[:p].T
        # Faces that share no series trade with the mountings alone; the smallest change of both is taken.
        normal = self.matrix.T @ self.matrix + constraints.T @ constraints
        value, vector = np.linalg.eigh(normal)
        inverse = np.where(value > _SINGULAR * value[-1], 1.0 / np.maximum(value, 1e-300), 0.0)
        return (vector * inverse) @ (vector.T @ self.matrix.T)

    @cached_property
    def covariance(self) -> np.ndarray:
        """float64[p + f, p + f]: of encoder errors and face deviations, for readings of variance 1."""
        part = self.estimator[: len(self.position_deg) + len(self.faces)]
        return part @ part.T

    @cached_property
    def lost_from_faces(self) -> np.ndarray:
        """float64[p, f]: what the encoder's curve takes over from the face deviations if the lost part is given to it.

        The encoder's true error is the estimate, plus this matrix times (face deviations found - true ones).
        """
        p, f = len(self.position_deg), len(self.faces)
        encoder, faces = self.lost[:p], self.lost[p : p + f]
        left, size, right = np.linalg.svd(faces, full_matrices=False)
        tied = size > _UNTIED  # lost directions of unit length: the rest is between encoder and mountings alone
        return -encoder @ (right[tied].T / size[tied]) @ left[:, tied].T

    @cached_property
    def lost_to_mountings(self) -> bool:
        """True when part of the encoder's error cannot be told from the mountings: settings that share no position.

        No knowledge of the polygon helps against that.
        """
        p, f = len(self.position_deg), len(self.faces)
        sizes = [np.linalg.svd(part, compute_uv=False) for part in (self.lost[:p], self.lost[p : p + f])]
        return int((sizes[0] > _UNTIED).sum()) > int((sizes[1] > _UNTIED).sum())

    @cached_property
    def orders(self) -> np.ndarray:
        """int[m]: the orders of the encoder's error that these positions show, 1 .. p/2."""
        return np.arange(1, len(self.position_deg) // 2 + 1)

    def basis(self, order: int) -> np.ndarray:
        """float64[p, 2 or 1]: cosine and sine of an order at the positions, orthonormal and without mean."""
        angle = np.radians(order * self.position_deg)
        waves = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        left, size, _ = np.linalg.svd(waves - waves.mean(axis=0), full_matrices=False)
        return left[:, size > 1e-3 * max(size.max(), 1e-300)]

    @cached_property
    def lost_fraction(self) -> np.ndarray:
        """float64[m]: how much of each order is lost, 0 none .. 1 all of it."""
        encoder = self.lost[: len(self.position_deg)]
        left, size, _ = np.linalg.svd(encoder, full_matrices=False)
        directions = left[:, size > _UNTIED]
        return np.array([np.sum((directions.T @ self.basis(order)) ** 2, axis=0).max() for order in self.orders])

    @property
    def lost_orders(self) -> tuple[int, ...]:
        """Orders of the encoder's error that cannot be told from the face deviations, wholly or in part."""
        return tuple(int(order) for order in self.orders[self.lost_fraction > _LOST_FRACTION])

    @cached_property
    def noise_factor(self) -> np.ndarray:
        """float64[m]: noise of each order, against as many readings of the encoder with all faces known.

        1 for a whole set; NaN for an order that is lost, wholly or in part.
        """
        p = len(self.position_deg)
        covariance = self.covariance[:p, :p] * (self.readings / p)
        factors = []
        for order, lost in zip(self.orders, self.lost_fraction, strict=True):
            basis = self.basis(order)
            variance = np.trace(basis.T @ covariance @ basis) / basis.shape[1]
            factors.append(np.sqrt(variance) if lost <= _LOST_FRACTION else np.nan)
        return np.array(factors)

    @cached_property
    def _means(self) -> np.ndarray:
        p, f = len(self.position_deg), len(self.faces)
        means = np.zeros((2, self.unknowns))
        means[0, :p], means[1, p : p + f] = 1.0, 1.0
        return means


def nominal_position_deg(faces: int, step_deg: float, setting, face) -> np.ndarray:
    """Where face `face` (from 0) meets the autocollimator at `setting` (from 1), not brought into one turn."""
    return np.asarray(face) * (360.0 / faces) + (np.asarray(setting) - 1) * step_deg


def _same_positions(nominal_deg: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The distinct positions in -0.01 .. 360 deg, and which of them each reading has."""
    folded = np.where(nominal_deg > 360.0 - SAME_POSITION_DEG, nominal_deg - 360.0, nominal_deg)
    order = np.argsort(folded, kind="stable")
    ordered = folded[order]
    group = np.concatenate([[0], np.cumsum(np.diff(ordered) > SAME_POSITION_DEG)])
    first = np.flatnonzero(np.diff(group, prepend=-1))
    last = np.append(first[1:], len(ordered)) - 1
    if (ordered[last] - ordered[first]).max() > 5 * SAME_POSITION_DEG:
        worst = int(np.argmax(ordered[last] - ordered[first]))
        problem = (
            f"the step brings readings to {ordered[first[worst]]:g} .. {ordered[last[worst]]:g} deg, "
            "neither one position nor several"
        )
        raise ValueError(problem)
    position = np.empty(len(folded), int)
    position[order] = group
    return np.array([ordered[a : b + 1].mean() for a, b in zip(first, last, strict=True)]), position
