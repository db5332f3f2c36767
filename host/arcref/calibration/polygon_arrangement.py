"""Cutting a polygon run into series.

Columns `round` and `direction` say where a series ends; without them the positions do.
"""

import numpy as np

from arcref.angle import wrapped
from arcref.calibration.faces_of_readings import FacesOfReadings, find_faces
from arcref.calibration.polygon_series import BACKWARD, FORWARD, PolygonSeries
from arcref.run_file import RunFile


def arrange_series(run: RunFile, column: str, position_deg, faces: int, rounds=None, directions=None) -> PolygonSeries:
    """Find faces and series of a run. `column` is where the positions stand; `rounds`, `directions`: int[n] or None.

    Raises `InputError`, which names the row, when a position belongs to no face, or a face is out of order, skipped,
    read twice or missing.
    """
    position_deg = np.asarray(position_deg, float)
    found = find_faces(run, column, position_deg, faces)
    walk = _Walk(run, column, position_deg, found, rounds, directions)
    walk.find_series()
    return walk.result()


class _Walk:
    """One passage over the rows, with what the messages need."""

    def __init__(self, run: RunFile, column: str, position_deg, found: FacesOfReadings, rounds, directions):
        self.run, self.column, self.position = run, column, position_deg
        self.face, self.angle_deg, self.faces = found.face, found.angle_deg, len(found.angle_deg)
        self.rounds, self.directions = rounds, directions
        self.series: list[tuple[int, int, int, int]] = []  # first reading, end, closing reading or -1, direction

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
        return wrapped(np.diff(self.face[start:end]), self.faces).astype(int)

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
