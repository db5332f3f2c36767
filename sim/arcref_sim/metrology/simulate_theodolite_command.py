"""`arcref simulate theodolite`: a run of mirror and autocollimating theodolite over an arc, whose answer is known."""

import click
import numpy as np

from arcref.input_error import InputError
from arcref_sim.metrology.encoder_options import ANGLE_DEG, SIGNED_ARCSEC, encoder_options, known_encoder, random_stream
from arcref_sim.metrology.quantity_option import Quantity
from arcref_sim.metrology.run_options import (
    check_missing,
    drift_option,
    missing_option,
    noise_option,
    rounds_option,
    setting_scatter_option,
    start_option,
)
from arcref_sim.metrology.run_output import check_run_outputs, simulated_by, write_run
from arcref_sim.metrology.simulated_theodolite import TheodoliteConditions, simulate_theodolite

LARGEST_RUN = 100_000
"""Readings of one run at most."""


@click.command()
@encoder_options
@click.option(
    "--alpha",
    type=Quantity("deg", 0, 45),
    default=6.7348,
    show_default=True,
    metavar="DEG",
    help="Angle of the encoder's axis to the mirror's plane's upright.",
)
@click.option(
    "--delta",
    type=ANGLE_DEG,
    default=129.3174,
    show_default=True,
    metavar="DEG",
    help="Azimuth of the axis, in the sense of the printed equations.",
)
@click.option(
    "--omega",
    type=Quantity("deg", -30, 30),
    default=-1.6617,
    show_default=True,
    metavar="DEG",
    help="Elevation of the mirror's normal at the start.",
)
@click.option("--first", type=ANGLE_DEG, default=0.0, show_default=True, metavar="DEG", help="Where the arc begins.")
@click.option("--last", type=ANGLE_DEG, default=40.0, show_default=True, metavar="DEG", help="Where it ends.")
@click.option(
    "--step",
    type=Quantity("deg", 0.001, 120),
    default=1.0,
    show_default=True,
    metavar="DEG",
    help="From one reading to the next.",
)
@start_option("Encoder reading where the mirror faces.")
@noise_option("--noise-azimuth", 0.76, "Of one reading (standard).")
@noise_option("--noise-zenith", 0.76, "Of one reading (standard).")
@click.option("--azimuth-zero", type=ANGLE_DEG, default=0.0, metavar="DEG", help="What the circle reads at the start.")
@click.option("--zenith-index", type=SIGNED_ARCSEC, default=0.0, metavar="ARCSEC", help="Index error of the zenith.")
@setting_scatter_option
@drift_option("Of the azimuth, over the run.")
@rounds_option(1000, 1, "How often the arc is gone through.")
@missing_option
def theodolite(output, truth, seed, **options):
    """Write a theodolite run of known truth over an arc.

    A plane mirror turns with the encoder, and an autocollimating theodolite reads its azimuth and zenith angle. The
    defaults are the case that Wang Tao et al. 2018 published.
    """
    check_run_outputs(output, truth, [options["curve"]])
    conditions = TheodoliteConditions(
        alpha_deg=options["alpha"],
        delta_deg=options["delta"],
        omega_deg=options["omega"],
        first_deg=options["first"],
        last_deg=options["last"],
        step_deg=options["step"],
        start_deg=options["start"],
        setting_scatter_arcsec=options["setting_scatter"],
        azimuth_noise_arcsec=options["noise_azimuth"],
        zenith_noise_arcsec=options["noise_zenith"],
        azimuth_zero_deg=options["azimuth_zero"],
        zenith_index_arcsec=options["zenith_index"],
        drift_arcsec=options["drift"],
        missing=options["missing"],
        rounds=options["rounds"],
    )
    _check_arc(conditions)
    encoder = known_encoder(seed, options)
    readings = simulate_theodolite(encoder, conditions, random_stream(seed, 2))
    metadata = simulated_by("theodolite", "simulated theodolite run", seed) | {
        "datum_deg": options["start"],
        "u_azimuth_arcsec": options["noise_azimuth"],
        "u_zenith_arcsec": options["noise_zenith"],
        "u_zenith_index_arcsec": abs(options["zenith_index"]),
        "u_mirror_walk_arcsec": 0.0,
        "u_levelling_arcsec": 0.0,
        "u_collimation_arcsec": 0.0,
        "u_temperature_arcsec": 0.0,
        "interpolation_amplitude_arcsec": encoder.within_line_amplitude_arcsec,
    }
    known = {
        "encoder": encoder.truth(),
        "conditions": vars(conditions),
        "rows": {"true_deg": np.round(readings.true_deg, 9).tolist()},
    }
    write_run(output, truth, metadata, readings.columns(), known, "theodolite", seed)


def _check_arc(conditions: TheodoliteConditions) -> None:
    """Raises `InputError` for an arc with too few readings, too many, or more than a turn."""
    arc_deg = conditions.last_deg - conditions.first_deg
    if not conditions.step_deg <= arc_deg < 360.0:
        raise InputError(
            f"--first {conditions.first_deg:g} and --last {conditions.last_deg:g} make an arc of {arc_deg:g} deg, "
            f"one step ({conditions.step_deg:g} deg) up to less than 360 deg was expected"
        )
    readings = conditions.angles_deg.size * conditions.rounds
    if readings > LARGEST_RUN:
        raise InputError(
            f"--step {conditions.step_deg:g} makes {readings} readings, at most {LARGEST_RUN} were expected"
        )
    check_missing(conditions.missing, readings)
