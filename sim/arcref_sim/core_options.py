"""Options of the verbs that run the compiled core, each declared once."""

from pathlib import Path

import click

from arcref_gateware.quadrature import SAMPLES_PER_WORD
from arcref_sim.verilator_build import DEFAULT_BUILD_FOLDER

samples_option = click.option(
    "--samples",
    type=click.Choice([str(samples) for samples in SAMPLES_PER_WORD]),
    default="4",
    show_default=True,
    help="Samples a word; the word clock is 200 MHz.",
)

build_folder_option = click.option(
    "--build-folder",
    type=click.Path(path_type=Path),
    default=DEFAULT_BUILD_FOLDER,
    show_default=True,
    metavar="FOLDER",
    help="Where compiled cores are kept.",
)
