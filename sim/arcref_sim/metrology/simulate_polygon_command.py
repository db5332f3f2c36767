"""`arcref simulate polygon`: a polygon run whose answer is known."""

import click
import numpy as np

from arcref.input_error import InputError
from arcref_sim.metrology.encoder_options import ANGLE_DEG, ARCSEC, encoder_options, known_encoder, random_stream
from arcref_sim.metrology.operator_mistakes import MISTAKES
from arcref_sim.metrology.polygon_artefact import PolygonArtefact
from arcref_sim.metrology.quantity_option import Quantity
from arcref_sim.metrology.run_options import (
    check_missing,
    drift_option,
    face_deviation_option,
    faces_option,
    missing_option,
    noise_option,
    rounds_option,
    setting_scatter_option,
    sign_option,
    start_option,
)
from arcref_sim.metrology.run_output import check_run_outputs, simulated_by, write_run
from arcref_sim.metrology.simulated_polygon import (
    Autocollimator,
    PolygonConditions,
    simulate_polygon,
)

FEWEST_FACES_OF_A_MISTAKE = 6
"""With fewer faces there is no place inside a round for a mistake."""


@click.command()
@encoder_options
@faces_option
@rounds_option(1000, 4, "Rounds, each closed.")
@click.option("--backward", is_flag=True, help="Follow each round by one in reverse.")
@start_option("Encoder reading at face 1.")
@noise_option("--noise", 0.2, "Of one x reading (standard).")
@click.option("--noise-y", type=ARCSEC, metavar="ARCSEC", help="Of one y reading.  [default: as --noise]")
@click.option("--no-y", is_flag=True, help="The autocollimator has no y.")
@setting_scatter_option
@face_deviation_option
@click.option(
    "--certificate-error",
    type=ARCSEC,
    default=0.05,
    show_default=True,
    metavar="ARCSEC",
    help="Of the certificate, each face (standard).",
)
@click.option("--no-certificate", is_flag=True, help="Leave the face deviations out of the file.")
@click.option("--face-pyramid", type=ARCSEC, default=0.0, metavar="ARCSEC", help="Pyramidal error of the faces.")
@click.option("--tilt", type=Quantity("arcsec", 0, 7200), default=0.0, metavar="ARCSEC", help="Tower tilt psi.")
@click.option("--tilt-azimuth", type=ANGLE_DEG, default=0.0, metavar="DEG", help="Its azimuth omega.")
@click.option("--roll", type=Quantity("arcmin", -300, 300), default=0.0, metavar="ARCMIN", help="Of the instrument.")
@click.option(
    "--stated-roll",
    type=Quantity("arcmin", -300, 300),
    metavar="ARCMIN",
    help="What the operator takes for the roll.  [default: the true one]",
)
@click.option("--scale-error", type=Quantity("%", -10, 10), default=0.0, metavar="PERCENT", help="Of the x and y read.")
@drift_option("Of x, in one round.")
@click.option(
    "--eccentricity", type=Quantity("mm", 0, 50), default=0.0, metavar="MM", help="Of the polygon on the shaft."
)
@click.option(
    "--face-flatness",
    type=Quantity("arcsec/mm", 0, 10),
    default=0.0,
    metavar="ARCSEC",
    help="Change of a face's direction over 1 mm (standard).",
)
@sign_option
@missing_option
@click.option("--mistake", type=click.Choice(list(MISTAKES)), help="A mistake of the operator.")
@click.option("--counts", is_flag=True, help="Write encoder counts in place of degrees.")
@click.option("--nothing-stated", is_flag=True, help="Leave out every stated uncertainty.")
def polygon(output, truth, seed, **options):
    """Write a polygon run of known truth.

    An encoder with a known error turns a polygon in front of an autocollimator. RUN.csv is what the operator would
    have written; RUN.truth.json beside it tells what is true.
    """
    check_run_outputs(output, truth, [options["curve"]])
    faces, rounds, missing = options["faces"], options["rounds"], options["missing"]
    inner_readings = (faces - 1) * rounds * (2 if options["backward"] else 1)
    check_missing(missing, inner_readings)
    if options["mistake"] and faces < FEWEST_FACES_OF_A_MISTAKE:
        raise InputError(f"--faces is {faces}, at least {FEWEST_FACES_OF_A_MISTAKE} were expected for a mistake")
    if options["no_certificate"] and (options["mistake"] or "").startswith("certificate"):
        raise InputError(f"--mistake {options['mistake']} needs the certificate that --no-certificate leaves out")
    encoder = known_encoder(seed, options)
    artefact, autocollimator, conditions = _set_up(seed, options)
    readings = simulate_polygon(encoder, artefact, autocollimator, conditions, random_stream(seed, 2))
    sentence = None
    if options["mistake"]:
        readings, sentence = MISTAKES[options["mistake"]](readings, faces, random_stream(seed, 3))
    known = {
        "encoder": encoder.truth(),
        "polygon": artefact.truth(),
        "autocollimator": vars(autocollimator),
        "conditions": vars(conditions),
        "mistake": options["mistake"] and {"name": options["mistake"], "what": sentence},
        "rows": {"face": (readings.face + 1).tolist(), "true_deg": np.round(readings.true_deg, 9).tolist()},
    }
    metadata = _metadata(seed, options, encoder)
    write_run(output, truth, metadata, readings.columns(**_columns_wanted(options)), known, "polygon", seed)


def _columns_wanted(options: dict) -> dict[str, bool]:
    return {"counts": options["counts"], "certificate": not options["no_certificate"], "y": not options["no_y"]}


def _set_up(seed: int, options: dict) -> tuple[PolygonArtefact, Autocollimator, PolygonConditions]:
    rng = random_stream(seed, 1)
    artefact = PolygonArtefact.random(
        rng,
        options["faces"],
        deviation_arcsec=options["face_deviation"],
        certificate_error_arcsec=options["certificate_error"],
        pyramid_arcsec=options["face_pyramid"],
        flatness_arcsec_per_mm=options["face_flatness"],
    )
    y_noise = options["noise"] if options["noise_y"] is None else options["noise_y"]
    autocollimator = Autocollimator(
        x_noise_arcsec=options["noise"],
        y_noise_arcsec=None if options["no_y"] else y_noise,
        roll_arcmin=options["roll"],
        scale_error=options["scale_error"] / 100.0,
        sign=int(options["sign"]),
    )
    conditions = PolygonConditions(
        rounds=options["rounds"],
        backward=options["backward"],
        start_deg=options["start"],
        setting_scatter_arcsec=options["setting_scatter"],
        tilt_arcsec=options["tilt"],
        tilt_azimuth_deg=options["tilt_azimuth"],
        drift_arcsec=options["drift"],
        eccentricity_mm=options["eccentricity"],
        eccentricity_deg=float(np.round(rng.uniform(0.0, 360.0), 3)),
        missing=options["missing"],
    )
    return artefact, autocollimator, conditions


def _metadata(seed: int, options: dict, encoder) -> dict[str, object]:
    """What an operator would state: settings of the run, and the uncertainties of the instruments."""
    roll = options["roll"] if options["stated_roll"] is None else options["stated_roll"]
    metadata = simulated_by("polygon", "simulated polygon run", seed) | {
        "faces": options["faces"],
        "autocollimator_sign": options["sign"],
        "autocollimator_roll_arcmin": roll if roll or options["tilt"] else None,
    }
    if options["nothing_stated"]:
        return metadata
    return metadata | {
        "u_face_certificate_arcsec": None if options["no_certificate"] else options["certificate_error"],
        "u_autocollimator_arcsec": abs(options["scale_error"]) / 100.0 * options["setting_scatter"],
        "u_autocollimator_roll_arcmin": abs(roll - options["roll"]),
        "eccentricity_mm": options["eccentricity"],
        "u_face_flatness_arcsec_per_mm": options["face_flatness"],
        "u_temperature_arcsec": 0.0,
        "tilt_limit_arcsec": options["tilt"] if options["no_y"] else None,
        "interpolation_amplitude_arcsec": encoder.within_line_amplitude_arcsec,
    }
