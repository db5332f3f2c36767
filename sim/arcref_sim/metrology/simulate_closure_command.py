"""`arcref simulate closure`: a closure run whose answer is known."""

import click
import numpy as np

from arcref_sim.metrology.encoder_options import ARCSEC, encoder_options, known_encoder, random_stream
from arcref_sim.metrology.polygon_artefact import PolygonArtefact
from arcref_sim.metrology.quantity_option import Quantity, WholeNumbers
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
from arcref_sim.metrology.simulated_closure import ClosureConditions, simulate_closure
from arcref_sim.metrology.simulated_polygon import Autocollimator


@click.command()
@encoder_options
@faces_option
@click.option(
    "--settings",
    type=WholeNumbers(1, 360),
    metavar="N|K,K,...",
    help="How many settings, or the numbers of those that are made.  [default: as many as faces]",
)
@click.option(
    "--setting-step",
    type=Quantity("deg", -360, 360),
    metavar="DEG",
    help="Turn of the polygon from one setting to the next.  [default: the face spacing]",
)
@rounds_option(100, 1, "How often all settings are made, the polygon mounted anew each time.")
@start_option("Encoder reading at face 1 of setting 1.")
@noise_option("--noise", 0.1, "Of one x reading (standard).")
@setting_scatter_option
@click.option(
    "--mounting-scatter",
    type=ARCSEC,
    default=30.0,
    show_default=True,
    metavar="ARCSEC",
    help="How closely the polygon is set.",
)
@face_deviation_option
@click.option(
    "--tilt",
    type=Quantity("arcsec", 0, 7200),
    default=0.0,
    metavar="ARCSEC",
    help="Tower tilt of each setting, its azimuth at random.",
)
@drift_option("Of x, in one setting.")
@sign_option
@missing_option
def closure(output, truth, seed, **options):
    """Write a closure run of known truth.

    The polygon is set at several positions on the encoder, and neither is known to whoever reduces the run.
    RUN.truth.json beside RUN.csv tells both.
    """
    check_run_outputs(output, truth, [options["curve"]])
    faces, missing = options["faces"], options["missing"]
    settings = options["settings"] or tuple(range(1, faces + 1))
    readings_whole = faces * len(settings) * options["rounds"]
    check_missing(missing, readings_whole)
    encoder = known_encoder(seed, options)
    polygon = PolygonArtefact.random(random_stream(seed, 1), faces, deviation_arcsec=options["face_deviation"])
    autocollimator = Autocollimator(options["noise"], None, sign=int(options["sign"]))
    conditions = ClosureConditions(
        settings=settings,
        setting_step_deg=360.0 / faces if options["setting_step"] is None else options["setting_step"],
        start_deg=options["start"],
        setting_scatter_arcsec=options["setting_scatter"],
        mounting_scatter_arcsec=options["mounting_scatter"],
        tilt_arcsec=options["tilt"],
        drift_arcsec=options["drift"],
        missing=missing,
        rounds=options["rounds"],
    )
    readings = simulate_closure(encoder, polygon, autocollimator, conditions, random_stream(seed, 2))
    metadata = simulated_by("closure", "simulated closure run", seed) | {
        "faces": faces,
        "setting_step_deg": f"{conditions.setting_step_deg:.10g}",
        "autocollimator_sign": options["sign"],
        "u_autocollimator_arcsec": 0.0,
        "u_face_deviation_arcsec": options["face_deviation"],
        "u_repeatability_arcsec": options["noise"],
        "u_autocollimator_roll_arcmin": 0.0,
        "u_eccentric_mounting_arcsec": 0.0,
        "u_temperature_arcsec": 0.0,
        "tilt_limit_arcsec": options["tilt"],
        "interpolation_amplitude_arcsec": encoder.within_line_amplitude_arcsec,
    }
    known = {
        "encoder": encoder.truth(),
        "polygon": polygon.truth(),
        "autocollimator": vars(autocollimator),
        "conditions": vars(conditions),
        "rows": {"true_deg": np.round(readings.true_deg, 9).tolist()},
    }
    write_run(output, truth, metadata, readings.columns(), known, "closure", seed)
