"""The options that describe the optics of a synthetic encoder."""

import math

import click
import numpy as np

from arcref.angle import LINES_PER_TURN
from arcref.subdivision.signal_model import ChannelModel, Harmonic, SignalModel
from arcref_sim.metrology.encoder_options import ANGLE_DEG, random_stream
from arcref_sim.metrology.quantity_option import NumberParts, Quantity
from arcref_sim.optics.grating_disc import GratingDisc
from arcref_sim.optics.optical_encoder import Interpolator, OpticalEncoder

PERCENT = Quantity("%", -20.0, 20.0)
_ARCSEC = Quantity("arcsec", 0.0, 60.0)

DEFAULT_TURN_ARCSEC = ((1, 0.9), (3, 0.7), (4, 0.8), (5, 0.5))
"""Graduation errors of the disc, order and amplitude; with two heads the odd ones cancel."""

_OPTIONS = (
    click.option("--amplitude", type=Quantity("V", 0.01, 100), default=1.0, show_default=True, metavar="V"),
    click.option("--offset-sine", type=PERCENT, default=0.35, show_default=True, metavar="PERCENT"),
    click.option("--offset-cosine", type=PERCENT, default=-0.25, show_default=True, metavar="PERCENT"),
    click.option("--gain", type=PERCENT, default=0.3, show_default=True, metavar="PERCENT", help="Sine over cosine."),
    click.option("--quadrature", type=Quantity("deg", -20, 20), default=0.1, show_default=True, metavar="DEG"),
    click.option("--third", type=PERCENT, default=0.5, show_default=True, metavar="PERCENT", help="Third harmonics."),
    click.option("--fifth", type=PERCENT, default=0.08, show_default=True, metavar="PERCENT", help="Fifth harmonics."),
    click.option(
        "--heads", type=click.Choice(["1", "2"]), default="2", show_default=True, help="2: opposite, signals added."
    ),
    click.option(
        "--eccentricity", type=Quantity("um", 0, 60), default=2.0, show_default=True, metavar="UM", help="Of the disc."
    ),
    click.option(
        "--ellipse", type=_ARCSEC, default=2.2, show_default=True, metavar="ARCSEC", help="Order 2 of the disc's shape."
    ),
    click.option(
        "--graduation",
        "harmonics",
        type=NumberParts(Quantity("cycles a turn", 1, 1000, whole=True), _ARCSEC, ANGLE_DEG),
        multiple=True,
        metavar="ORDER:ARCSEC:PHASE_DEG",
        help="Graduation error of the disc; may be repeated.  [default: orders 1, 3, 4, 5]",
    ),
    click.option(
        "--line-noise", type=_ARCSEC, default=0.02, show_default=True, metavar="ARCSEC", help="Of each single line."
    ),
    click.option(
        "--conversion-rate",
        type=Quantity("Hz", 0, 1e9),
        default=0.0,
        metavar="HZ",
        help="Of the interpolator; 0 follows at once.",
    ),
    click.option("--delay", type=Quantity("ns", 0, 1e6), default=5000.0, show_default=True, metavar="NS"),
    click.option(
        "--hysteresis", type=Quantity("counts", 0, 1000), default=0.0, metavar="COUNTS", help="Of the interpolator."
    ),
)


def optics_options(command):
    """Decorates a command with the options; `optical_encoder` makes the encoder of them."""
    for option in reversed(_OPTIONS):
        command = option(command)
    return command


SIGNAL_OPTIONS = ("amplitude", "offset_sine", "offset_cosine", "gain", "quadrature", "third", "fifth")
DISC_OPTIONS = ("heads", "eccentricity", "ellipse", "harmonics", "line_noise")
OPTION_NAMES = (*SIGNAL_OPTIONS, *DISC_OPTIONS, "conversion_rate", "delay", "hysteresis")


def optical_encoder(
    seed: int, *, amplitude, offset_sine, offset_cosine, gain, quadrature, third, fifth, heads, eccentricity, ellipse,
    harmonics, line_noise, conversion_rate, delay, hysteresis,
) -> OpticalEncoder:  # fmt: skip
    """The encoder that the options describe; phases that are not given come from the seed."""
    rng = random_stream(seed, 20)
    phases = rng.uniform(0.0, 360.0, 2 + len(DEFAULT_TURN_ARCSEC))
    terms = harmonics or tuple(
        (order, size, float(phase)) for (order, size), phase in zip(DEFAULT_TURN_ARCSEC, phases[2:], strict=True)
    )
    third_phase, fifth_phase = rng.uniform(-0.6, 0.6, 2)
    sine = {
        1: Harmonic(amplitude * (1 + gain / 200), 0.0),
        3: Harmonic(amplitude * third / 100, float(third_phase)),
        5: Harmonic(amplitude * fifth / 100, float(fifth_phase)),
    }
    # A cosine's third harmonic has the other sign against the sine's: both make order 4.
    cosine = {
        1: Harmonic(amplitude * (1 - gain / 200), math.pi / 2 + math.radians(quadrature)),
        3: Harmonic(amplitude * third / 100, math.pi / 2 + float(third_phase) + 0.2),
        5: Harmonic(amplitude * fifth / 100, math.pi / 2 + float(fifth_phase) - 0.2),
    }
    signals = SignalModel(
        ChannelModel(amplitude * offset_sine / 100, sine), ChannelModel(amplitude * offset_cosine / 100, cosine)
    )
    disc = GratingDisc(
        eccentricity_um=eccentricity,
        eccentricity_deg=float(phases[0]),
        ellipse_arcsec=ellipse,
        ellipse_deg=float(phases[1]),
        harmonics=tuple(terms),
        line_error_arcsec=line_noise * rng.standard_normal(LINES_PER_TURN) if line_noise else None,
    )
    head_deg = (0.0,) if heads == "1" else (0.0, 180.0)
    return OpticalEncoder(disc, signals, head_deg, Interpolator(conversion_rate, delay, hysteresis))


def optics_truth(encoder: OpticalEncoder) -> dict:
    """All there is to know, ready for JSON."""
    disc, chip, angle = encoder.disc, encoder.interpolator, np.arange(360)
    line_deg = (np.arange(512) + 0.5) * (360 / 512)
    return {
        "sine": encoder.signals.sine.to_json(),
        "cosine": encoder.signals.cosine.to_json(),
        "head_deg": list(encoder.head_deg),
        "disc": {
            "radius_mm": disc.radius_mm,
            "eccentricity_um": disc.eccentricity_um,
            "eccentricity_deg": disc.eccentricity_deg,
            "eccentricity_of_one_head_arcsec": disc.eccentricity_arcsec,
            "ellipse_arcsec": disc.ellipse_arcsec,
            "ellipse_deg": disc.ellipse_deg,
            "harmonics": [list(term) for term in disc.harmonics],
        },
        "interpolator": vars(chip),
        "angle_deg": angle.tolist(),
        "error_over_turn_arcsec": np.round(encoder.turn_arcsec(angle), 6).tolist(),
        "line_deg": line_deg.tolist(),
        "error_within_line_arcsec": np.round(encoder.within_line_arcsec(line_deg), 6).tolist(),
    }
