"""The options that the simulated runs share: the known encoder, the seed, and the files to write."""

from pathlib import Path

import click
import numpy as np

from arcref.radial_basis_network import RadialBasisNetwork
from arcref.rom_command import read_curve
from arcref_sim.metrology.known_encoder import Harmonic, KnownEncoder
from arcref_sim.metrology.quantity_option import NumberParts, Quantity

FILE = click.Path(path_type=Path)

ARCSEC = Quantity("arcsec", 0.0, 1e4)
SIGNED_ARCSEC = Quantity("arcsec", -1e4, 1e4)
ANGLE_DEG = Quantity("deg", -360.0, 360.0)

DEFAULT_AMPLITUDES_ARCSEC = {1: 1.2, 2: 0.8, 3: 0.4, 4: 0.3, 8: 0.3}
"""The encoder when none is described: 3 arcsec in all, phases from the seed. Order 1 is the disc's eccentricity, order
2 what two diametral heads leave of it, order 8 a term close to the limit of a 24-face polygon."""

_AMPLITUDE = Quantity("arcsec", 0.0, 200.0)

_OPTIONS = (
    click.option("-o", "--output", type=FILE, required=True, metavar="RUN.csv", help="Run file to write."),
    click.option(
        "--truth",
        type=FILE,
        metavar="TRUTH.json",
        help="Everything that is known about the run.  [default: RUN.truth.json beside it]",
    ),
    click.option(
        "--seed",
        type=Quantity("", 0, 2**63 - 1, whole=True),
        default=1,
        show_default=True,
        metavar="N",
        help="The same seed gives the same run.",
    ),
    click.option(
        "--harmonic",
        "harmonics",
        type=NumberParts(Quantity("cycles a turn", 1, 2048, whole=True), _AMPLITUDE, ANGLE_DEG),
        multiple=True,
        metavar="ORDER:ARCSEC:PHASE_DEG",
        help="A term of the encoder's error over the turn, ARCSEC * sin(ORDER * angle + PHASE); may be repeated.  "
        "[default: orders 1, 2, 3, 4, 8 of 3 arcsec in all]",
    ),
    click.option(
        "--line-harmonic",
        "line_harmonics",
        type=NumberParts(Quantity("cycles a line", 1, 64, whole=True), Quantity("arcsec", 0.0, 20.0), ANGLE_DEG),
        multiple=True,
        metavar="ORDER:ARCSEC:PHASE_DEG",
        help="A term of the error within a grating line, ORDER cycles a line; may be repeated.",
    ),
    click.option(
        "--curve",
        type=FILE,
        metavar="CAL.json|POLYGON.csv",
        help="The encoder's error over the turn is the RBF fit of this curve.",
    ),
    click.option(
        "--hysteresis", type=ARCSEC, default=0.0, metavar="ARCSEC", help="Reverse reading less forward reading."
    ),
    click.option(
        "--hysteresis-variation",
        type=ARCSEC,
        default=0.0,
        metavar="ARCSEC",
        help="How much of it comes and goes once a turn.",
    ),
)


def encoder_options(command):
    """Decorates a command with the shared options; `known_encoder` makes the encoder of them."""
    for option in reversed(_OPTIONS):
        command = option(command)
    return command


def random_stream(seed: int, stream: int) -> np.random.Generator:
    """Random numbers for one purpose, so that an option of one part leaves the numbers of the others alone."""
    return np.random.default_rng([seed, stream])


def known_encoder(seed: int, options: dict) -> KnownEncoder:
    """The encoder that a command's options describe. Raises `InputError` when the curve's file cannot be used."""
    curve = options["curve"]
    terms = [Harmonic(*parts) for parts in options["harmonics"]]
    if not terms and curve is None:
        phases = random_stream(seed, 0).uniform(0.0, 360.0, len(DEFAULT_AMPLITUDES_ARCSEC))
        pairs = zip(DEFAULT_AMPLITUDES_ARCSEC.items(), np.round(phases, 3), strict=True)
        terms = [Harmonic(order, amplitude, float(phase)) for (order, amplitude), phase in pairs]
    terms += [Harmonic.within_line(*parts) for parts in options["line_harmonics"]]
    fit = RadialBasisNetwork.fit(read_curve(curve)).evaluate if curve else None
    return KnownEncoder(tuple(terms), fit, options["hysteresis"], options["hysteresis_variation"])
