"""The sections of a report that belong to a closure calibration: faces, orders, residuals."""

import numpy as np

from arcref.calibration.calibration_result import ReportSection
from arcref.calibration.closure_plan import plan_sentences
from arcref.calibration.closure_plots import faces_plot, orders_plot, residuals_plot
from arcref.calibration.closure_run import ClosureRun
from arcref.calibration.closure_solution import ClosureSolution

WORST_SHOWN = 8


def closure_sections(
    run: ClosureRun, solution: ClosureSolution, face_u_arcsec: np.ndarray | None, plots: bool = True
) -> tuple[ReportSection, ...]:
    """The sections in the order of the report, with their plots unless nobody will look."""
    return (
        _faces_section(run, solution, face_u_arcsec, plots),
        _orders_section(run, plots),
        _residuals_section(run, solution, plots),
    )


def outlier_rows(solution: ClosureSolution) -> list[int]:
    """Readings (of the run) that stand out, the worst first."""
    size, limit = np.abs(solution.studentized_residual), solution.outlier_limit
    return [int(index) for index in np.argsort(-size, kind="stable") if size[index] > limit]


def reading_name(run: ClosureRun, index: int) -> str:
    """Where a reading stands: row of the file, setting and face."""
    name = f"row {run.run.rows[run.row[index]]} (setting {run.setting[index]}, face {run.face[index] + 1}"
    return name + (f", round {run.round[index]})" if run.rounds > 1 else ")")


def _faces_section(
    run: ClosureRun, solution: ClosureSolution, u_arcsec: np.ndarray | None, plots: bool
) -> ReportSection:
    deviation = solution.face_deviation_arcsec
    readings = np.bincount(run.design.face)
    from_first = deviation - deviation[0]
    rows = tuple(
        (
            f"{face + 1}",
            f"{deviation[index]:+.3f}",
            f"{from_first[index]:+.3f}",
            "-" if u_arcsec is None else f"{2 * u_arcsec[index]:.3f}",
            f"{readings[index]}",
        )
        for index, face in enumerate(run.design.faces)
    )
    paragraphs = [
        "Deviations of the faces from their nominal angles, found together with the encoder's error and without a "
        "certificate. Positive: the face comes later as the encoder counts up. Their mean is zero; the column from "
        f"face {run.design.faces[0] + 1} is for comparison with a certificate that counts from it. The uncertainty is "
        "that of the scatter, about the mean.",
    ]
    if run.design.lost_orders:
        paragraphs.append("What the settings could not separate stands here, not in the encoder's curve.")
    columns = (
        "face",
        "deviation / arcsec",
        f"from face {run.design.faces[0] + 1} / arcsec",
        "U (k=2) / arcsec",
        "readings",
    )
    drawn = (faces_plot(run, deviation, u_arcsec),) if plots else ()
    return ReportSection("Faces of the polygon", tuple(paragraphs), columns, rows, drawn)


def _orders_section(run: ClosureRun, plots: bool) -> ReportSection:
    design = run.design
    rows = tuple(
        (str(order), "lost" if np.isnan(factor) else f"{factor:.3f}")
        for order, factor in zip(design.orders, design.noise_factor, strict=True)
    )
    meaning = (
        "Noise of each order of the encoder's error, against as many readings of the encoder with all faces known: "
        "1 is what a whole set gives."
    )
    paragraphs = (*plan_sentences(design), meaning)
    drawn = (orders_plot(design),) if plots else ()
    return ReportSection("What the settings separate", paragraphs, ("order", "noise"), rows, drawn)


def _residuals_section(run: ClosureRun, solution: ClosureSolution, plots: bool) -> ReportSection:
    studentized = solution.studentized_residual
    worst = np.argsort(-np.abs(studentized), kind="stable")[:WORST_SHOWN]
    outlier = np.abs(studentized) > solution.outlier_limit
    rows = tuple(
        (
            reading_name(run, int(index)),
            f"{solution.residual_arcsec[index]:+.3f}",
            f"{studentized[index]:+.2f}",
            "outlier" if outlier[index] else "",
        )
        for index in worst
    )
    text = (
        f"{run.design.readings} readings for {run.design.rank} unknowns leave {run.design.degrees_of_freedom} degrees "
        "of freedom. The table has the readings that fit worst; the third column is the residual over the standard "
        f"deviation that all other readings give it. Above {solution.outlier_limit:.2f} it is an outlier: in one run "
        "of a thousand without a mistake any reading is as far off. Nothing was left out."
    )
    if run.design.degrees_of_freedom < 2:
        text = "No readings are left over to check the others."
        rows = ()
    columns = ("reading", "residual / arcsec", "in standard deviations", "")
    drawn = (residuals_plot(run, solution.residual_arcsec, outlier),) if plots else ()
    return ReportSection("Residuals of the readings", (text,), columns if rows else (), rows, drawn)
