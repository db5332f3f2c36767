"""The report of a calibration as one HTML page that needs nothing beside itself and prints on A4."""

import json
from functools import partial

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from arcref.calibration.calibration_result import CalibrationResult
from arcref.calibration.metadata_keys import KEYS_BY_NAME
from arcref.calibration.report.bar_plots import budget_plot, harmonics_plot
from arcref.calibration.report.calibration_record import calibration_record
from arcref.calibration.report.error_plots import error_plot, polar_plot, residual_plot
from arcref.plot_style import with_own_ids

TEMPLATE = "calibration.html.j2"

TITLES = {
    "polygon": "Calibration by polygon and autocollimator",
    "closure": "Calibration by closure of polygon and encoder",
    "theodolite": "Calibration by mirror and theodolite over an arc",
}


def calibration_page(result: CalibrationResult, as_left: CalibrationResult | None = None) -> str:
    """The page's text. Every value that came from a file is escaped.

    Each number of the record stands in a `<data>` element with its full value and, in `data-path`, its place in the
    record, so that page and JSON cannot differ.
    """
    record = calibration_record(result, as_left)
    results = [each for each in (result, as_left) if each is not None]
    environment = Environment(
        loader=PackageLoader("arcref.calibration.report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template(TEMPLATE).render(
        record=record,
        runs=record["runs"],
        title=TITLES[result.kind],
        n=partial(number_element, record),
        unit_of=unit_of,
        error_svg=error_plot(result, as_left),
        polar_svg=polar_plot(result, as_left),
        harmonics_svg=harmonics_plot(record["runs"]),
        residual_svgs=_of_each_run([residual_plot(each) for each in results]),
        budget_svgs=_of_each_run([budget_plot(run["budget"]) for run in record["runs"]]),
        section_svgs=[
            [
                [with_own_ids(plot, f"run{run}-section{place}") for plot in section.plots]
                for place, section in enumerate(each.sections)
            ]
            for run, each in enumerate(results)
        ],
        provenance_json=[json.dumps(run["provenance"], indent=2, ensure_ascii=False) for run in record["runs"]],
    )


def _of_each_run(plots: list) -> list:
    """The same plot of each run, None where there is none, without ids in common."""
    return [plot and with_own_ids(plot, f"run{run}") for run, plot in enumerate(plots)]


def number_element(
    record: dict, path: str, digits: int = 3, *, sign: bool = False, factor: float = 1.0, none="–"
) -> Markup:
    """The number at `path` ("runs.0.budget.combined_arcsec") as a `<data>` element, or `none` when it is null.

    `digits` after the point; `factor`: shown times this (100 for percent), the value stays as it is.
    """
    value = record
    for part in path.split("."):
        value = value[int(part)] if isinstance(value, list) else value[part]
    if value is None:
        return Markup("{}").format(none)
    shown = f"{value * factor:{'+' if sign else ''}.{digits}f}"
    if not float(shown):
        shown = f"{0:.{digits}f}"  # neither -0.00 nor +0.00
    attributes = Markup(' data-factor="{}"').format(f"{factor:g}") if factor != 1.0 else ""
    return Markup('<data value="{}" data-path="{}"{}>{}</data>').format(
        repr(value), path, attributes, shown.replace("-", "−")
    )


def unit_of(key: str) -> str:
    """The unit of a metadata key's number, "" for text."""
    unit = KEYS_BY_NAME[key].unit
    return {None: "", "1": "", "deg C": "°C"}.get(unit, unit)
