"""The uncertainty budget of a calibration, after the Guide to the Expression of Uncertainty in Measurement (GUM)."""

import math
from dataclasses import dataclass

from scipy.special import stdtrit

COVERAGE_FACTOR = 2.0
"""k of every expanded uncertainty: about 95 % of a normal distribution."""


@dataclass(frozen=True)
class Contribution:
    """One input quantity's part in the uncertainty of a corrected angle.

    `type`: "A" (from the scatter of this run) or "B" (from elsewhere); `distribution`: "normal", "rectangular",
    "triangular", "arcsine" or "two-point"; `u`: standard uncertainty in `unit`; `sensitivity`: arcsec per `unit`;
    `degrees_of_freedom`: of `u`, infinite unless it was estimated; `basis`: one phrase on where `u` comes from.
    """

    name: str
    type: str
    distribution: str
    u: float
    unit: str
    sensitivity: float
    basis: str
    degrees_of_freedom: float = math.inf

    @property
    def u_arcsec(self) -> float:
        """The part in the result, a standard uncertainty."""
        return abs(self.sensitivity) * self.u


@dataclass(frozen=True)
class MissingInput:
    """An input quantity that nobody stated: its name, and the metadata key of the run file that would state it."""

    name: str
    metadata_key: str


@dataclass(frozen=True)
class UncertaintyBudget:
    """All contributions, and what is missing. Contributions are taken as uncorrelated (GUM equation 10)."""

    contributions: tuple[Contribution, ...]
    missing: tuple[MissingInput, ...] = ()

    @property
    def combined_arcsec(self) -> float:
        """Combined standard uncertainty of what was stated."""
        return math.hypot(*(contribution.u_arcsec for contribution in self.contributions))

    def without(self, name: str) -> "UncertaintyBudget":
        """The budget without the contribution called `name`."""
        return UncertaintyBudget(tuple(each for each in self.contributions if each.name != name), self.missing)

    @property
    def expanded_arcsec(self) -> float:
        """Expanded uncertainty, `COVERAGE_FACTOR` times the combined one."""
        return COVERAGE_FACTOR * self.combined_arcsec

    @property
    def effective_degrees_of_freedom(self) -> float:
        """After Welch and Satterthwaite (GUM equation G.2b)."""
        parts = sum(c.u_arcsec**4 / c.degrees_of_freedom for c in self.contributions)
        return self.combined_arcsec**4 / parts if parts else math.inf

    @property
    def coverage_factor_95(self) -> float:
        """The k that would cover 95.45 % with the effective degrees of freedom (GUM table G.2): 2 for many."""
        return float(stdtrit(min(self.effective_degrees_of_freedom, 1e9), 0.5 + 0.9545 / 2))
