"""How the plots of all reports look, and how a figure becomes SVG that stands inside a page."""

import io
import re

BEFORE_COLOUR, AFTER_COLOUR, READING_COLOUR = "#c0561c", "#1f5fa8", "#8a2b3f"
"""The error as measured, the error after correction, and single readings."""

RIVAL_COLOURS = ("#1f5fa8", "#c0561c", "#2f7d4f", "#7a4ea3")
"""Curves that stand side by side, first to last."""

INK, QUIET, GRID = "#20262d", "#5b6470", "#e4e7eb"

WIDTH_IN = 7.4
"""Width of a plot that fills the page, so that its 9 point text stays 9 point on A4."""

STYLE = {
    "font.family": "sans-serif",
    "font.size": 9,
    "axes.edgecolor": QUIET,
    "axes.labelcolor": INK,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.titlesize": 9,
    "axes.titlelocation": "left",
    "axes.titlecolor": QUIET,
    "grid.color": GRID,
    "grid.linewidth": 0.6,
    "lines.linewidth": 1.3,
    "xtick.color": QUIET,
    "ytick.color": QUIET,
    "legend.frameon": False,
    "svg.fonttype": "none",
    "svg.hashsalt": "arcref",
}
"""Settings for `matplotlib.rc_context`. The salt makes the same figure the same text."""


def svg(figure, name: str) -> str:
    """The figure as an SVG element for an HTML page: no head, date, fixed size, or reference outside the page.

    `name` (letters, digits, -) begins every id in it, so that plots on one page do not share ids.
    """
    text = io.StringIO()
    figure.savefig(text, format="svg", metadata={"Date": None, "Creator": None, "Format": None, "Type": None})
    content = text.getvalue()
    content = content[content.index("<svg") :]
    content = re.sub(r"<metadata>.*?</metadata>", "", content, flags=re.DOTALL)
    head, rest = content.split(">", 1)
    head = re.sub(r' (width|height|xmlns:xlink)="[^"]*"', "", head)
    rest = rest.replace("xlink:href=", "href=")
    used = set(re.findall(r'(?:url\(|href=")#([^")]+)', rest))
    rest = re.sub(r' id="([^"]*)"', lambda found: found[0] if found[1] in used else "", rest)
    return with_own_ids(f'{head} role="img">{rest}', name)


def with_own_ids(svg_text: str, name: str) -> str:
    """The SVG with `name` before each id and each reference to one, for a page that holds the same plot of two runs."""
    svg_text = re.sub(r' id="', f' id="{name}-', svg_text)
    return re.sub(r'(url\(|href=")#', rf"\g<1>#{name}-", svg_text)
