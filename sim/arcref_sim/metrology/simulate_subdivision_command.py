"""`arcref simulate subdivision`: runs of an encoder of known optics, for its error within a line and over the turn."""

import click
import numpy as np

from arcref.angle import COUNTS_PER_TURN
from arcref.input_error import InputError
from arcref_sim.metrology.encoder_options import ANGLE_DEG, ARCSEC, FILE, SIGNED_ARCSEC, random_stream
from arcref_sim.metrology.polygon_artefact import PolygonArtefact
from arcref_sim.metrology.quantity_option import NumberParts, Quantity
from arcref_sim.metrology.run_output import check_run_outputs, simulated_by, write_run
from arcref_sim.metrology.simulated_polygon import Autocollimator, PolygonConditions, simulate_polygon
from arcref_sim.metrology.simulated_subdivision import (
    EvenMotion,
    simulate_edge_times,
    simulate_fine_scan,
    simulate_samples,
)
from arcref_sim.optics.optics_options import OPTION_NAMES, optical_encoder, optics_options, optics_truth

RUNS = ("samples", "edges", "scan", "polygon")


@click.command()
@click.option("-o", "--output", type=FILE, required=True, metavar="RUN.csv", help="Run file to write.")
@click.option("--truth", type=FILE, metavar="TRUTH.json", help="What is true.  [default: RUN.truth.json beside it]")
@click.option(
    "--run",
    "kind",
    type=click.Choice(RUNS),
    required=True,
    help="Samples of the signals, edge times, fine scan of a face, or a polygon run of the same encoder.",
)
@click.option("--seed", type=Quantity("", 0, 2**63 - 1, whole=True), default=1, show_default=True, metavar="N")
@click.option(
    "--noise-seed",
    type=Quantity("", 0, 2**63 - 1, whole=True),
    metavar="N",
    help="Another run of the same encoder.  [default: as --seed]",
)
@optics_options
@click.option("--speed", type=Quantity("r/s", -100, 100), default=1.0, show_default=True, help="Edges, samples.")
@click.option(
    "--ripple",
    "ripples",
    type=NumberParts(Quantity("cycles a turn", 0.001, 1e6), Quantity("%", 0, 30), ANGLE_DEG),
    multiple=True,
    metavar="ORDER:PERCENT:PHASE_DEG",
    help="Ripple of the speed; may be repeated.  [default: 8:0.1:0]",
)
@click.option("--turns", type=Quantity("", 0.002, 50), default=1.0, show_default=True, help="Edges: turns passed.")
@click.option(
    "--every", type=Quantity("counts", 1, 2047, whole=True), default=61, show_default=True, help="Edges: each N-th."
)
@click.option("--clock", type=Quantity("ns", 0, 1e5), default=1.25, show_default=True, help="Edges: time stamps.")
@click.option("--jitter", type=Quantity("ns", 0, 1e6), default=1.0, show_default=True, help="Edges: of each.")
@click.option("--lines", type=Quantity("", 1, 20), default=3.0, show_default=True, help="Scan: lines passed.")
@click.option("--readings", type=Quantity("", 2, 100000, whole=True), default=360, show_default=True, help="Scan.")
@click.option(
    "--noise",
    type=ARCSEC,
    default=0.1,
    show_default=True,
    metavar="ARCSEC",
    help="Scan, polygon: of one autocollimator reading.",
)
@click.option("--scale-error", type=Quantity("%", -4, 4), default=0.0, help="Scan: of the autocollimator.")
@click.option("--drift", type=SIGNED_ARCSEC, default=0.0, help="Scan: of x, from its first reading to its last.")
@click.option("--periods", type=Quantity("", 1, 20000), default=50.0, show_default=True, help="Samples: lines passed.")
@click.option("--samples-per-period", type=Quantity("", 8, 4096), default=64.0, show_default=True)
@click.option("--noise-mv", type=Quantity("mV", 0, 1e4), default=1.0, show_default=True, help="Samples: of each.")
@click.option("--faces", type=Quantity("", 3, 360, whole=True), default=24, show_default=True, help="Polygon.")
@click.option("--rounds", type=Quantity("", 1, 1000, whole=True), default=4, show_default=True, help="Polygon.")
def subdivision(output, truth, kind, seed, noise_seed, **options):
    """Write a run of an encoder whose disc, heads, signals and interpolator are known.

    The same seed and optics make the same encoder in every run. RUN.csv is what an operator would have written;
    RUN.truth.json beside it tells what is true.
    """
    check_run_outputs(output, truth, [])
    if kind in ("edges", "samples") and abs(options["speed"]) < 1e-3:
        raise InputError(f"--speed is {options['speed']:g} r/s, at least 0.001 r/s either way was expected")
    encoder = optical_encoder(seed, **{name: options[name] for name in OPTION_NAMES})
    rng = random_stream(seed if noise_seed is None else noise_seed, 21 + RUNS.index(kind))
    metadata = simulated_by("subdivision", f"simulated run: {kind}", seed)
    try:
        columns, more = _RUNS[kind](encoder, rng, options)
        known = {"encoder": optics_truth(encoder), "run": kind}
    except ValueError as error:
        raise InputError(f"--eccentricity is {options['eccentricity']:g} um: {error}") from None
    write_run(output, truth, metadata | more, columns, known, "subdivision", seed)


def _motion(options: dict) -> EvenMotion:
    ripples = options["ripples"] or ((8.0, 0.1, 0.0),)
    return EvenMotion(options["speed"], tuple((order, percent / 100.0, phase) for order, percent, phase in ripples))


def _samples(encoder, rng, options):
    columns = simulate_samples(
        encoder,
        _motion(options),
        rng,
        periods=options["periods"],
        samples_per_period=options["samples_per_period"],
        start_deg=float(rng.uniform(0.0, 360.0)),
        noise_v=options["noise_mv"] / 1000.0,
    )
    signals = encoder.signals
    return columns, {
        "line_count": 4096,
        "cosine_sign": f"{signals.cosine_sign:+d}",
        "count_zero_phase_deg": float(np.degrees(signals.mean_error_rad)),
    }


def _edges(encoder, rng, options):
    columns = simulate_edge_times(
        encoder,
        _motion(options),
        rng,
        turns=options["turns"],
        every=options["every"],
        start_count=int(rng.integers(COUNTS_PER_TURN)),
        clock_ns=options["clock"],
        jitter_ns=options["jitter"],
    )
    in_step = max((percent for order, percent, _ in options["ripples"] if order % 4096 == 0), default=0.0)
    return columns, {"line_count": 4096, "line_ripple_percent": in_step}


def _scan(encoder, rng, options):
    columns = simulate_fine_scan(
        encoder,
        rng,
        lines=options["lines"],
        readings=options["readings"],
        start_count=int(rng.integers(COUNTS_PER_TURN)),
        noise_arcsec=options["noise"],
        scale_error=options["scale_error"] / 100.0,
        drift_arcsec=options["drift"],
    )
    return columns, {"line_count": 4096, "autocollimator_sign": "+1", "u_autocollimator_arcsec": 0.0}


def _polygon(encoder, rng, options):
    artefact = PolygonArtefact.random(rng, options["faces"], deviation_arcsec=2.0, certificate_error_arcsec=0.0)
    readings = simulate_polygon(
        encoder, artefact, Autocollimator(options["noise"], options["noise"]), PolygonConditions(options["rounds"]), rng
    )
    stated = ("u_face_certificate_arcsec", "u_autocollimator_arcsec", "u_autocollimator_roll_arcmin")
    stated += ("u_eccentric_mounting_arcsec", "u_temperature_arcsec")
    within_line = float(np.ptp(encoder.within_line_arcsec(np.arange(512) * (360 / 512)))) / 2
    return readings.columns(), {
        "faces": options["faces"],
        "autocollimator_sign": "+1",
        "interpolation_amplitude_arcsec": within_line,
        **dict.fromkeys(stated, 0.0),
    }


_RUNS = {"samples": _samples, "edges": _edges, "scan": _scan, "polygon": _polygon}
