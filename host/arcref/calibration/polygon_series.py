"""The order of a polygon run: which face each reading is of, and how the readings make series.

A series is one round in one direction: every face once, and then, if the operator did so, the first face again, the
closing reading. Columns `round` and `direction` say where a series ends; without them the positions do.
"""

from dataclasses import dataclass

import numpy as np

from arcref.run_file import RunFile

OFF_FACE_LIMIT_DEG = 0.5
"""How far a position may lie from its face: autocollimators see less than this."""

FORWARD, BACKWARD = 1, -1

_UNITS = {"arcsec": 3600.0, "arcmin": 60.0, "radians": np.pi / 180.0, "counts": 2**23 / 360.0}


@dataclass(frozen=True, eq=False)
class PolygonSeries:
    """How n readings of a polygon lie in series; face 0 is the one that was read first.

    `angle_deg`: float64[faces], the encoder's angle at each face, first that of face 0; `face`: int[n];
    `reading_of_face`: int[series, faces], which reading each series has of a face; `closing_reading`: int[series], the
    reading of its first face again, -1 for none; `first_reading`: int[series]; `round`, `direction`: of each series.
    """

    angle_deg: np.ndarray
    face: np.ndarray
    reading_of_face: np.ndarray
    first_reading: np.ndarray
    closing_reading: np.ndarray
    round: tuple[int, ...]
    direction: tuple[int, ...]

    @property
    def theta_deg(self) -> np.ndarray:
        """How far from face 0 each face stands, float64[faces]."""
        return self.angle_deg - self.angle_deg[0]

    @property
    def weight(self) -> np.ndarray:
        """Of each series in the mean, float64[series]: both directions count alike, whatever their number."""
        direction = np.array(self.direction)
        return 1.0 / (np.array([(direction == own).sum() for own in direction]) * len(set(self.direction)))


def arrange_series(run: RunFile, column: str, position_deg, faces: int, rounds=None, directions=None) -> PolygonSeries:
    """Find faces and series of a run. `column` is where the positions stand; `rounds`, `directions`: int[n] or None.

    Raises `InputError`, which names the row, when a position belongs to no face, or a face is out of order, skipped,
    read twice or missing.
    """
    walk = _Walk(run, column, np.asarray(position_deg, float), faces, rounds, directions)
    walk.find_faces()
    walk.find_series()
    return walk.result()


class _Walk:
    """One passage over the rows, with what the messages need."""

    def __init__(self, run, column, position_deg, faces, rounds, directions):
        self.run, self.column, self.position, self.faces = run, column, position_deg, faces
        self.rounds, self.directions = rounds, directions
        self.spacing = 360.0 / faces
        self.series: list[tuple[int, int, int, int]] = []  # first reading, end, closing reading or -1, direction

    def find_faces(self) -> None:
        """The face of each reading, from its place on the grid of faces."""
        position, spacing = self.position, self.spacing
        self._refuse_other_units()
        # The median forgives a slip of the pen in the first row.
        phase = np.median(_wrapped(position - position[0], spacing))
        grid = position[0] + phase
        off = _wrapped(position - grid, spacing)
        limit = min(OFF_FACE_LIMIT_DEG, spacing / 8)
        wrong = np.flatnonzero(np.abs(off) > limit)
        if wrong.size:
            self._refuse_off_face(wrong, off, grid)
        self.face = np.mod(np.rint((position - grid) / spacing).astype(int), self.faces)
        first = np.round(np.mod(grid + 180.0, 360.0) - 180.0, 3) + 0.0
        self.angle_deg = (first if first >= 0 else first + 360.0) + spacing * np.arange(self.faces)

    def _refuse_other_units(self) -> None:
        if len(self.position) < 3:
            return
        step = np.median(np.abs(np.diff(self.position)))
        for unit, factor in _UNITS.items():
            if abs(step / (self.spacing * factor) - 1) < 0.01:
                problem = (
                    f"the positions step by {step:g}, which is one face ({self.spacing:g} deg) in {unit}; "
                    f"degrees were expected"
                )
                raise self.run.error(problem, reading=1, column=self.column)

    def _refuse_off_face(self, wrong: np.ndarray, off: np.ndarray, grid: float) -> None:
        index = int(wrong[0])
        others = [name for name in self.run.columns if name != self.column and name.endswith(("_deg", "_arcsec"))]
        for name in others:
            values = self.run[name]
            if np.ptp(values) > 180 and np.all(np.abs(_wrapped(values - values[0], self.spacing)) < OFF_FACE_LIMIT_DEG):
                problem = f"the positions fit no faces, but {name} does: the two columns seem to be swapped"
                raise self.run.error(problem, reading=index, column=self.column)
        step = np.median(np.abs(_wrapped(np.diff(self.position), 360.0)))
        likely = round(360.0 / step) if step > 0.5 else 0
        if wrong.size > 2 and likely != self.faces and likely and abs(360.0 / likely / step - 1) < 0.002:
            problem = (
                f"the positions step by {step:.6g} deg, as with {likely} faces, but the metadata says {self.faces}"
            )
            raise self.run.error(problem, reading=index, column=self.column)
        nominal = grid + self.spacing * round((self.position[index] - grid) / self.spacing)
        problem = (
            f"{self.position[index]:.6g} deg is {abs(off[index]):.4g} deg from the nearest face ({nominal:.6g} deg), "
            f"at most {min(OFF_FACE_LIMIT_DEG, self.spacing / 8):.4g} deg were expected"
        )
        raise self.run.error(problem, reading=index, column=self.column)

    def find_series(self) -> None:
        """Cut the run into series: first at the labels, then where a round is full or turns back."""
        count = len(self.face)
        labels = [
            tuple(int(label[i]) for label in (self.rounds, self.directions) if label is not None) for i in range(count)
        ]
        start, seen = 0, {}
        for index in range(1, count + 1):
            if index < count and labels[index] == labels[start]:
                continue
            if labels[start] in seen and self.rounds is not None:
                problem = (
                    f"{self._label(start)} begins a second time, it already stood in rows "
                    f"{seen[labels[start]]}; each was expected once, in one piece"
                )
                raise self.run.error(problem, reading=start, column="round")
            seen[labels[start]] = f"{self.run.rows[start]} to {self.run.rows[index - 1]}"
            self._cut(start, index)
            start = index

    def _cut(self, start: int, end: int) -> None:
        """Cut the readings start .. end - 1, which bear the same labels."""
        while start < end:
            direction = self._direction(start, end)
            index = start + 1
            while index < min(end, start + self.faces) and self.face[index] == self._after(index - 1, direction):
                index += 1
            if index < start + self.faces:
                if index < end:
                    self._refuse_face(start, index, end, direction)
                self._refuse_short(start, index, direction)
            closing, following = -1, index
            if index < end and self.face[index] == self.face[start]:
                closing, following = index, index + 1
                goes_on = following < end and self.face[following] == self._after(index, direction)
                if goes_on and self.rounds is None:
                    following = index  # the turning went on: this reading ends one round and begins the next
            self.series.append((start, index, closing, direction))
            if following < end and self.rounds is not None and self._turned(following, end) == direction:
                problem = (
                    f"{self._label(start)} goes on behind its {self.faces} faces"
                    f"{' and their closing reading' if closing >= 0 else ''}; a new round was expected"
                )
                raise self.run.error(problem, reading=following, column="round")
            start = following

    def _turned(self, index: int, end: int) -> int:
        """The direction in which the readings from `index` on go."""
        if self.directions is not None:
            return int(self.directions[index])
        return self._direction(index, end)

    def _direction(self, start: int, end: int) -> int:
        """Of the series that begins at `start`: its label, or else the way in which the faces follow each other."""
        if self.directions is not None:
            return int(self.directions[start])
        steps = self._steps(start, min(end, start + self.faces))
        if steps.size and abs(steps[0]) == 1 and (steps.size < 2 or steps[1] == steps[0]):
            return int(steps[0])
        return BACKWARD if (steps < 0).sum() > (steps > 0).sum() else FORWARD

    def _steps(self, start: int, end: int) -> np.ndarray:
        return _wrapped(np.diff(self.face[start:end]), self.faces).astype(int)

    def _after(self, index: int, direction: int) -> int:
        return (self.face[index] + direction) % self.faces

    def _refuse_face(self, start: int, index: int, end: int, direction: int) -> None:
        """A face that was not expected: say which of the slips it looks like."""
        expected = self._after(index - 1, direction)
        read_before = np.flatnonzero(self.face[start:index] == self.face[index])
        steps = self._steps(start, end)
        if self.directions is not None and (steps == -direction).sum() > (steps == direction).sum():
            way, faces = ("forward", "falls back") if direction == FORWARD else ("backward", "goes on")
            problem = (
                f"the direction is {direction:+d} ({way}), but the position {faces} from {self.position[index - 1]:g} "
                f"to {self.position[index]:g} deg: was it turned clockwise for counter-clockwise?"
            )
            raise self.run.error(problem, reading=index, column=self.column)
        rest = self.face[index : min(end, start + self.faces + 1)]
        if self.face[index] == self.face[index - 1]:
            problem = f"{self._name(index)} is read twice in a row, {self._face_name(expected)} was expected"
        elif read_before.size:
            row = self.run.rows[start + int(read_before[0])]
            problem = (
                f"{self._name(index)} was already read in row {row} of this round, "
                f"{self._face_name(expected)} was expected"
            )
        elif expected in rest:
            later = index + int(np.flatnonzero(rest == expected)[0])
            problem = (
                f"{self._name(index)} stands where {self._face_name(expected)} was expected, which comes only in row "
                f"{self.run.rows[later]}: faces in the wrong order"
            )
        else:
            skipped = int(((self.face[index] - expected) * direction) % self.faces)
            what = self._face_name(expected)
            if skipped > 1:
                what += f" and {skipped - 1} more"
            problem = f"{self._name(index)} follows {self._name(index - 1)}: {what} was skipped"
        raise self.run.error(problem, reading=index, column=self.column)

    def _refuse_short(self, start: int, index: int, direction: int) -> None:
        read = index - start
        missing = self._face_name(self._after(index - 1, direction))
        many = "" if self.faces - read == 1 else f" and {self.faces - read - 1} more"
        problem = (
            f"{self._label(start)} ends after {read} of {self.faces} faces, {missing}{many} "
            f"{'is' if self.faces - read == 1 else 'are'} missing"
        )
        raise self.run.error(problem, reading=index - 1, column=self.column)

    def _label(self, reading: int) -> str:
        number = int(self.rounds[reading]) if self.rounds is not None else len(self.series) + 1
        name = f"round {number}"
        if self.directions is not None:
            name += " forward" if self.directions[reading] == FORWARD else " backward"
        return name

    def _face_name(self, face: int) -> str:
        return f"face {face + 1} ({float(f'{self.angle_deg[face] % 360:.5g}'):g} deg)"

    def _name(self, reading: int) -> str:
        return self._face_name(int(self.face[reading]))

    def result(self) -> PolygonSeries:
        """Everything as arrays."""
        first, end, closing, direction = (list(column) for column in zip(*self.series, strict=True))
        reading_of_face = np.empty((len(first), self.faces), int)
        for row, (start, stop) in enumerate(zip(first, end, strict=True)):
            reading_of_face[row, self.face[start:stop]] = np.arange(start, stop)
        if self.rounds is not None:
            rounds = [int(self.rounds[start]) for start in first]
        else:
            rounds = [direction[: index + 1].count(direction[index]) for index in range(len(first))]
        return PolygonSeries(
            self.angle_deg,
            self.face,
            reading_of_face,
            np.array(first),
            np.array(closing),
            tuple(rounds),
            tuple(direction),
        )


def _wrapped(values, period: float) -> np.ndarray:
    """Values brought into -period/2 .. period/2."""
    return values - period * np.rint(np.asarray(values) / period)
