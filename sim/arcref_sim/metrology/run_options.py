"""Options that say how a simulated run is carried out, each declared once for all the kinds of run that have it."""

from collections.abc import Callable

import click

from arcref.input_error import InputError
from arcref_sim.metrology.encoder_options import ANGLE_DEG, ARCSEC, SIGNED_ARCSEC
from arcref_sim.metrology.quantity_option import Quantity

Decorator = Callable[[Callable], Callable]

faces_option = click.option(
    "--faces",
    type=Quantity("", 3, 360, whole=True),
    default=24,
    show_default=True,
    metavar="N",
    help="Faces of the polygon.",
)

face_deviation_option = click.option(
    "--face-deviation", type=ARCSEC, default=2.0, show_default=True, metavar="ARCSEC", help="Of the polygon's faces."
)

setting_scatter_option = click.option(
    "--setting-scatter",
    type=ARCSEC,
    default=2.0,
    show_default=True,
    metavar="ARCSEC",
    help="How closely the shaft is stopped.",
)

sign_option = click.option(
    "--sign", type=click.Choice(["+1", "-1"]), default="+1", show_default=True, help="Autocollimator sign."
)

missing_option = click.option(
    "--missing", type=Quantity("", 0, 1000000, whole=True), default=0, metavar="N", help="Readings left out."
)


def check_missing(missing: int, readings: int) -> None:
    """Raises `InputError` when more than half of the readings are to be left out."""
    if missing > readings // 2:
        raise InputError(f"--missing is {missing}, at most half of the {readings} readings may be left out")


def rounds_option(most: int, default: int, help: str) -> Decorator:
    """`--rounds`, from 1 to `most`."""
    return click.option(
        "--rounds",
        type=Quantity("", 1, most, whole=True),
        default=default,
        show_default=True,
        metavar="N",
        help=help,
    )


def noise_option(name: str, default_arcsec: float, help: str) -> Decorator:
    """The standard deviation of one reading."""
    return click.option(name, type=ARCSEC, default=default_arcsec, show_default=True, metavar="ARCSEC", help=help)


def start_option(help: str) -> Decorator:
    """`--start`, an encoder reading."""
    return click.option("--start", type=ANGLE_DEG, default=0.0, metavar="DEG", help=help)


def drift_option(help: str) -> Decorator:
    """`--drift`, of what is read."""
    return click.option("--drift", type=SIGNED_ARCSEC, default=0.0, metavar="ARCSEC", help=help)
