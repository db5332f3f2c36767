"""The uncertainty of an angle corrected within the line, after a run of samples."""

import math

import numpy as np

from arcref.angle import ARCSEC_PER_COUNT, COUNTS_PER_LINE
from arcref.calibration.correction_budget import HALF_COUNT_U
from arcref.calibration.stated_contributions import temperature
from arcref.calibration.stated_values import stated_number
from arcref.calibration.uncertainty_budget import Contribution, MissingInput, UncertaintyBudget
from arcref.correction_rom import SUBDIVISION_CELL_COUNTS
from arcref.subdivision.samples_findings import SamplesFindings

SPEED_KEY, ZERO_PHASE_KEY, U_ZERO_PHASE_KEY = "speed_change_percent", "count_zero_phase_deg", "u_count_zero_phase_deg"


def samples_budget(found: SamplesFindings) -> UncertaintyBudget:
    """Contributions to an angle corrected by the second table, about its mean over the line."""
    terms = [*_measured(found), *_phase(found), *_count_zero(found), *temperature(found.run.run, 1.0)]
    terms += table_contributions(found.slope_arcsec_per_deg)
    contributions = tuple(term for term in terms if isinstance(term, Contribution))
    return UncertaintyBudget(contributions, tuple(term for term in terms if isinstance(term, MissingInput)))


def table_contributions(slope_arcsec_per_deg: float) -> list[Contribution]:
    """What the second table adds, whatever way the curve was measured; the slope is rms over the line."""
    cell = 360.0 * SUBDIVISION_CELL_COUNTS / COUNTS_PER_LINE
    return [
        Contribution(
            "rounding of the ROM", "B", "rectangular", HALF_COUNT_U, "count", ARCSEC_PER_COUNT,
            "the correction is a whole count, half a count either way",
        ),
        Contribution(
            "one ROM entry for four counts", "B", "rectangular", cell / math.sqrt(12), "deg", slope_arcsec_per_deg,
            "slope of the curve, rms over the line, over one cell's width",
        ),
        Contribution(
            "resolution of the reading", "B", "rectangular", HALF_COUNT_U, "count", ARCSEC_PER_COUNT,
            "a reading is a whole count, half a count either way",
        ),
    ]  # fmt: skip


def speed_change_percent(found: SamplesFindings) -> tuple[float, str, str, float] | None:
    """Standard uncertainty of the speed's change along a line, %, with type, basis and degrees of freedom.

    As stated (a limit, rectangular), or else from the changes of the periods' durations; None when neither is known.
    """
    run = found.run
    stated = stated_number(run.run, SPEED_KEY)
    if stated is not None:
        return stated / math.sqrt(3), "B", "stated limit, rectangular; taken as the same in every period", math.inf
    if run.slip is None or run.slip.size < 2:
        return None
    changes = 100 * float(np.sqrt(np.mean(run.slip**2)))
    periods = run.samples.periods
    basis = f"scatter of the periods' durations, {changes:.3g} % from one to the next; the mean of {periods} periods"
    return changes / math.sqrt(periods), "A", basis, float(run.slip.size)


def _measured(found: SamplesFindings):
    periods = found.run.samples.periods
    freedom = float(max(1, (periods if periods == 1 else periods - 1)) * found.parameters.samples_per_period)
    noise = float(np.sqrt(np.mean(found.noise_arcsec**2)))
    basis = f"scatter of the samples about the model, through the identification; {periods} periods"
    yield Contribution("noise of the samples", "A", "normal", noise, "arcsec", 1.0, basis, freedom)
    reading = found.reading_noise_arcsec
    basis = "the same noise in one reading to be corrected; an interpolator of less bandwidth has less"
    yield Contribution("noise of one reading", "A", "normal", reading, "arcsec", 1.0, basis, freedom)
    basis = "mean period less the model, where it is beyond the noise: harmonics the model has not"
    yield Contribution("what the model lacks", "A", "normal", found.lack_of_fit_arcsec, "arcsec", 1.0, basis)
    if len(found.map.error_arcsec) > 1:
        change = float(np.sqrt(np.mean(found.map.change_arcsec**2)))
        blocks = len(found.map.error_arcsec)
        basis = f"scatter of the error over {blocks} blocks of lines, noise taken off; one table serves all lines"
        yield Contribution("change from line to line", "A", "normal", change, "arcsec", 1.0, basis, blocks - 1.0)


def _phase(found: SamplesFindings):
    known = speed_change_percent(found)
    if known is None:
        yield MissingInput("change of the speed along a line", SPEED_KEY)
        return
    u, kind, basis, freedom = known
    shape = "rectangular" if kind == "B" else "normal"
    yield Contribution("phase of the samples", kind, shape, u, "%", found.speed_sensitivity_arcsec, basis, freedom)


def _count_zero(found: SamplesFindings):
    if found.run.count_zero_phase_deg is None:
        yield MissingInput("where in the line the count is zero", ZERO_PHASE_KEY)
        return
    u = stated_number(found.run.run, U_ZERO_PHASE_KEY)
    if u is None:
        yield MissingInput("phase at which the count is zero", U_ZERO_PHASE_KEY)
        return
    basis = "stated; the table stands beside its place by as much"
    yield Contribution("phase of the count's zero", "B", "normal", u, "deg", found.slope_arcsec_per_deg, basis)
