"""The report of a subdivision calibration as one HTML page that needs nothing beside itself and prints on A4."""

import json
from functools import partial

from jinja2 import ChoiceLoader, Environment, PackageLoader, StrictUndefined

from arcref.calibration.calibration_result import CalibrationResult
from arcref.calibration.report.bar_plots import budget_plot
from arcref.calibration.report.calibration_page import number_element, unit_of
from arcref.plot_style import with_own_ids
from arcref.subdivision.report.line_error_plot import line_error_plot
from arcref.subdivision.report.subdivision_record import subdivision_record

TEMPLATE = "subdivision.html.j2"

ROWS_SHOWN = 32
"""Rows of the table on the page, evenly chosen; the CSV table has all."""


def subdivision_page(result: CalibrationResult) -> str:
    """The page's text. Every value that came from a file is escaped; each number is an element with its full value."""
    record = subdivision_record(result)
    loaders = [PackageLoader("arcref.subdivision.report"), PackageLoader("arcref.calibration.report")]
    environment = Environment(
        loader=ChoiceLoader(loaders), autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    return environment.get_template(TEMPLATE).render(
        record=record,
        n=partial(number_element, record),
        unit_of=unit_of,
        shown=range(0, len(record["table"]), max(1, len(record["table"]) // ROWS_SHOWN)),
        error_svg=line_error_plot(result),
        budget_svg=budget_plot(record["budget"]),
        section_svgs=[
            [with_own_ids(plot, f"section{place}") for plot in section.plots]
            for place, section in enumerate(result.sections)
        ],
        provenance_json=json.dumps(record["provenance"], indent=2, ensure_ascii=False),
    )
