"""Bar plots of the report: the harmonics of the error curve, and the contributions to its uncertainty."""

from arcref.plot_style import AFTER_COLOUR, BEFORE_COLOUR, INK, QUIET, STYLE, WIDTH_IN, svg


def harmonics_plot(runs: list[dict]) -> str | None:
    """Amplitudes by order for the runs of a record; orders that an error within a line would look like are marked.

    None when no run has harmonics.
    """
    import matplotlib
    from matplotlib.figure import Figure

    shown = [run for run in runs if run["harmonics"]]
    if not shown:
        return None
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(3.7, 3.4), layout="constrained")
        axes = figure.add_subplot()
        width = 0.8 / len(shown)
        for place, (run, colour) in enumerate(zip(shown, (BEFORE_COLOUR, AFTER_COLOUR), strict=False)):
            order = [row["order"] + (place - (len(shown) - 1) / 2) * width for row in run["harmonics"]]
            size = [row["amplitude_arcsec"] for row in run["harmonics"]]
            u = [row["u_amplitude_arcsec"] for row in run["harmonics"]]
            axes.bar(order, size, width, color=colour, label=run["label"])
            if None not in u:
                axes.errorbar(order, size, [2 * each for each in u], fmt="none", ecolor=INK, elinewidth=0.7)
        top = max(row["amplitude_arcsec"] for run in shown for row in run["harmonics"]) or 1.0
        axes.set_ylim(0, 1.3 * top)
        _mark_aliases(axes, shown[0]["harmonics"])
        axes.set_xlim(0.4, max(row["order"] for run in shown for row in run["harmonics"]) + 0.6)
        axes.xaxis.set_major_locator(matplotlib.ticker.MaxNLocator(13, integer=True))
        axes.grid(axis="x", visible=False)
        axes.set_xlabel("order, waves a turn")
        axes.set_ylabel("amplitude / arcsec, with k=2")
        if len(shown) > 1:
            figure.legend(loc="outside lower center", ncols=2)
        return svg(figure, "harmonics")


def budget_plot(budget: dict) -> str | None:
    """Contributions of a budget's record, largest first, and the combined uncertainty; None when there are none."""
    import matplotlib
    from matplotlib.figure import Figure

    terms = sorted(budget["contributions"], key=lambda term: term["u_arcsec"])
    if not terms:
        return None
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH_IN, 0.5 + 0.21 * (len(terms) + 1)), layout="constrained")
        axes = figure.add_subplot()
        size = [term["u_arcsec"] for term in terms] + [budget["combined_arcsec"]]
        colour = [BEFORE_COLOUR if term["type"] == "A" else AFTER_COLOUR for term in terms] + [INK]
        axes.barh(range(len(size)), size, 0.66, color=colour)
        for place, value in enumerate(size):
            axes.annotate(f"{value:.3f}", (value, place), (4, 0), textcoords="offset points", va="center", fontsize=8)
        axes.set_yticks(range(len(size)), [term["name"] for term in terms] + ["combined"])
        axes.tick_params(axis="y", length=0, labelcolor=INK)
        axes.set_xlim(0, 1.12 * (max(size) or 1.0))
        axes.grid(axis="y", visible=False)
        axes.spines["left"].set_visible(False)
        axes.set_xlabel("standard uncertainty in the corrected angle / arcsec")
        handles = [matplotlib.patches.Patch(color=BEFORE_COLOUR), matplotlib.patches.Patch(color=AFTER_COLOUR)]
        axes.legend(handles, ["type A, from this run", "type B, from elsewhere"], loc="lower right", fontsize=8)
        return svg(figure, "budget")


def _mark_aliases(axes, rows: list[dict]) -> None:
    """Shade each order that an error within a grating line would be taken for, and say which."""
    top = axes.get_ylim()[1]
    for row in rows:
        if not row["looks_like_orders"]:
            continue
        axes.axvspan(row["order"] - 0.5, row["order"] + 0.5, color="#f3d9a4", alpha=0.6, linewidth=0, zorder=0)
        text = ", ".join(str(order) for order in row["looks_like_orders"])
        axes.annotate(
            f"so looks order {text}",
            (row["order"], 0.98 * top),
            rotation=90,
            ha="center",
            va="top",
            fontsize=7.5,
            color=QUIET,
        )
