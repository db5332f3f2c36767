"""The plots of a closure calibration: face deviations, residuals by setting and face, and the noise of each order."""

import numpy as np

from arcref.calibration.closure_design import SettingsDesign
from arcref.calibration.closure_run import ClosureRun
from arcref.plot_style import AFTER_COLOUR, BEFORE_COLOUR, QUIET, READING_COLOUR, STYLE, WIDTH_IN, svg


def faces_plot(run: ClosureRun, deviation_arcsec: np.ndarray, u_arcsec: np.ndarray | None) -> str:
    """Face deviations with their expanded uncertainty."""
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    number = run.design.faces + 1
    with rc_context(STYLE):
        figure = Figure(figsize=(WIDTH_IN, 2.5), layout="constrained")
        axes = figure.add_subplot()
        axes.bar(number, deviation_arcsec, color=AFTER_COLOUR, width=0.65)
        if u_arcsec is not None:
            axes.errorbar(number, deviation_arcsec, 2 * u_arcsec, fmt="none", ecolor=READING_COLOUR, capsize=2)
        axes.axhline(0, color=QUIET, linewidth=0.8)
        axes.set_xlim(0, run.faces + 1)
        axes.set_xlabel("face")
        axes.set_ylabel("deviation / arcsec")
        if u_arcsec is not None:
            axes.set_title("Face deviations about their mean, bars the expanded uncertainty (k=2)")
        return svg(figure, "closure-faces")


def residuals_plot(run: ClosureRun, residual_arcsec: np.ndarray, outlier: np.ndarray) -> str:
    """What the solution leaves of each reading, by series and face; outliers ringed, missing readings blank."""
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    design = run.design
    table = np.full((design.series_count, run.faces), np.nan)
    faces = design.faces[design.face]
    table[design.series, faces] = residual_arcsec
    limit = max(float(np.nanmax(np.abs(table))), 1e-6)
    with rc_context(STYLE):
        height = min(1.0 + 0.17 * design.series_count, 6.0)
        figure = Figure(figsize=(WIDTH_IN, max(height, 1.8)), layout="constrained")
        axes = figure.add_subplot()
        extent = (0.5, run.faces + 0.5, design.series_count + 0.5, 0.5)
        image = axes.imshow(table, cmap="RdBu_r", vmin=-limit, vmax=limit, aspect="auto", extent=extent)
        axes.plot(faces[outlier] + 1, design.series[outlier] + 1, "o", mfc="none", mec=BEFORE_COLOUR, mew=1.8, ms=9)
        labels = _series_labels(run)
        shown = np.unique(np.linspace(0, len(labels) - 1, min(len(labels), 12)).round().astype(int))
        axes.set_yticks(shown + 1, [labels[index] for index in shown])
        axes.set_xlabel("face")
        axes.set_ylabel("setting" if run.rounds == 1 else "round: setting")
        axes.grid(visible=False)
        figure.colorbar(image, ax=axes, label="residual / arcsec", pad=0.02)
        return svg(figure, "closure-residuals")


def orders_plot(design: SettingsDesign) -> str:
    """How much the settings chosen raise the noise of each order, and which orders they lose."""
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    lost = np.isnan(design.noise_factor)
    top = max(2.0, 1.15 * float(np.nanmax(np.append(design.noise_factor, 1.0))))
    with rc_context(STYLE):
        figure = Figure(figsize=(WIDTH_IN, 2.3), layout="constrained")
        axes = figure.add_subplot()
        axes.bar(design.orders[~lost], design.noise_factor[~lost], color=AFTER_COLOUR, width=0.65)
        axes.bar(
            design.orders[lost], np.full(lost.sum(), top), color=BEFORE_COLOUR, alpha=0.35, width=0.9, label="lost"
        )
        axes.axhline(1.0, color=QUIET, linewidth=0.8, linestyle="--")
        axes.set_ylim(0, top)
        axes.set_xlim(0.3, design.orders[-1] + 0.7)
        axes.set_xlabel("order of the encoder's error")
        axes.set_ylabel("noise, 1: a whole set")
        if lost.any():
            axes.legend(loc="upper right")
        return svg(figure, "closure-orders")


def _series_labels(run: ClosureRun) -> list[str]:
    """The setting of each series, with its round when there are several."""
    _, first = np.unique(run.design.series, return_index=True)
    several = run.rounds > 1
    return [f"{run.round[index]}: {run.setting[index]}" if several else f"{run.setting[index]}" for index in first]
