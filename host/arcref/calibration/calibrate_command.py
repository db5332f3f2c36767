"""`arcref calibrate`: from a run file to an error curve with its uncertainty, and a report."""

import click

from arcref.verb_group import VerbGroup

VERBS = {
    "polygon": "arcref.calibration.calibrate_polygon_command:polygon",
    "closure": "arcref.calibration.calibrate_closure_command:closure",
    "theodolite": "arcref.calibration.calibrate_theodolite_command:theodolite",
    "subdivision": "arcref.subdivision.calibrate_subdivision_command:subdivision",
}
"""Methods of calibration: name and `module:function`."""


@click.group(cls=VerbGroup, targets=VERBS)
def calibrate():
    """Measure the encoder's error: from a run file to a calibration and its report."""
