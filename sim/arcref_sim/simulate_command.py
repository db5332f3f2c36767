"""`arcref simulate`: tests of the simulated core, and measurements whose answer is known."""

import click

from arcref.verb_group import VerbGroup

SIMULATE_VERBS = {
    "zero-return": "arcref_sim.zero_return_command:zero_return",
    "polygon": "arcref_sim.metrology.simulate_polygon_command:polygon",
    "closure": "arcref_sim.metrology.simulate_closure_command:closure",
    "theodolite": "arcref_sim.metrology.simulate_theodolite_command:theodolite",
    "subdivision": "arcref_sim.metrology.simulate_subdivision_command:subdivision",
    "corrected": "arcref_sim.simulate_corrected_command:corrected",
}
"""Verbs of the group: name and `module:function`."""


@click.group(cls=VerbGroup, targets=SIMULATE_VERBS)
def simulate():
    """Simulate the core's zero-return test, and calibration runs of known truth."""
