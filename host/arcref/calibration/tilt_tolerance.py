"""How much tower tilt an encoder's accuracy allows.

Tian Liude et al., Acta Optica Sinica 35(5) 2015 0512003: the tilt may cost a third of the accuracy asked of the
encoder, and costs 0.5337e-5 psi^2 arcsec at its azimuth of 90 deg (equation 12). Their table 1 prints 140 and 178
arcsec for the first two grades, where that formula gives 125.0 and 176.7; the other five agree, rounded up. At azimuths
of 67.5, 112.5, 247.5 and 292.5 deg the largest error against face 1 is 9.7 % more; `strict` allows for that.
"""

import math
from dataclasses import dataclass

from arcref.calibration.stated_values import stated_number
from arcref.calibration.tower_tilt import ARCSEC_PER_RADIAN
from arcref.run_file import RunFile

SHARE = 1 / 3
"""Part of the accuracy that the tilt may take."""

COEFFICIENT = 0.5337e-5
"""Largest error over psi^2 at omega = 90 deg, per arcsec, as printed (0.533740e-5 at theta = 111.47 deg)."""

LARGEST_COEFFICIENT = (1 + math.sqrt(2)) / 2 / ARCSEC_PER_RADIAN
"""Largest error over psi^2 at any omega, 0.58522e-5 per arcsec, at omega = 67.5 deg and theta = 225 deg."""

GRADES = {1: (0.25, 140), 2: (0.5, 178), 3: (1, 250), 4: (2, 354), 5: (5, 559), 6: (10, 791), 7: (30, 1369)}
"""Grade of the encoder: accuracy asked of it and tolerance of the tilt, both in arcsec, as table 1 prints them."""


@dataclass(frozen=True)
class TiltTolerance:
    """Tolerances of the tilt for one accuracy, in arcsec; `published_arcsec` is None outside the table's grades."""

    accuracy_arcsec: float
    grade: int | None
    published_arcsec: float | None
    formula_arcsec: float
    strict_arcsec: float

    @classmethod
    def of_accuracy(cls, accuracy_arcsec: float, grade: int | None = None) -> "TiltTolerance":
        """The tolerances for an accuracy of +-`accuracy_arcsec`."""
        allowed = accuracy_arcsec * SHARE
        return cls(
            accuracy_arcsec,
            grade,
            None if grade is None else GRADES[grade][1],
            math.sqrt(allowed / COEFFICIENT),
            math.sqrt(allowed / LARGEST_COEFFICIENT),
        )

    @classmethod
    def of_grade(cls, grade: int) -> "TiltTolerance":
        """The tolerances for a grade of the published table."""
        return cls.of_accuracy(GRADES[grade][0], grade)

    @classmethod
    def of_run(cls, run: RunFile) -> "TiltTolerance | None":
        """The tolerances for what `run` states, None when it states neither grade nor accuracy.

        Raises `InputError` for a grade that is none, an accuracy of 0, and when both stand there.
        """
        grade, accuracy = stated_number(run, "encoder_grade"), stated_number(run, "required_accuracy_arcsec")
        if grade is not None and accuracy is not None:
            raise run.metadata_error("encoder_grade", "required_accuracy_arcsec stands here too, one was expected")
        if grade is not None:
            if grade not in GRADES:
                raise run.metadata_error("encoder_grade", f"{grade:g}, one of 1 .. {max(GRADES)} was expected")
            return cls.of_grade(int(grade))
        if accuracy is None:
            return None
        if accuracy == 0:
            raise run.metadata_error("required_accuracy_arcsec", "0 arcsec, more than that was expected")
        return cls.of_accuracy(accuracy)
