"""The plot of the strobe delay study. Run as a module to write it: `python -m arcref_sim.twin.strobe_delay_plot`."""

import io
import sys
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.figure import Figure

from arcref.atomic_file import write_bytes
from arcref.rom_image import load_rom
from arcref_sim.twin.strobe_delay_study import DELAY_NS, DelayStudy, delay_study, formula_arcsec
from arcref_sim.verilator_build import DEFAULT_BUILD_FOLDER

PLOT = Path("docs/images/strobe_delay.svg")
BEFORE, AFTER = "#b3402a", "#1f6f8b"


def delay_plot(studies: list[DelayStudy]) -> bytes:
    """The plot as SVG: error over speed with both settings, and what is left once the delay is set, in counts."""
    with matplotlib.rc_context({"svg.hashsalt": "arcref", "font.size": 9, "svg.fonttype": "none"}):
        figure = Figure(figsize=(8, 3.4), layout="constrained")
        left, right = figure.subplots(1, 2)
        without = [study for study in studies if not study.strobe_delay_samples]
        matched = [study for study in studies if study.strobe_delay_samples]
        speeds = np.array([-65.0, 65.0])
        left.plot(speeds, formula_arcsec(speeds), color=BEFORE, lw=1, alpha=0.6, label="delay x speed")
        for chosen, colour, name in (
            (without, BEFORE, "strobe delay 0"),
            (matched, AFTER, "strobe delay set to match"),
        ):
            speed = [study.speed_rps for study in chosen]
            left.plot(speed, [study.mean_arcsec for study in chosen], "o", color=colour, ms=5, label=name)
        left.set(xlabel="speed, r/s", ylabel="captured less true angle, arcsec")
        left.set_title(f"An interpolator {DELAY_NS / 1000:g} us late", loc="left")
        left.legend(frameon=False, loc="upper right")
        names = [f"{study.speed_rps:+g}" for study in matched]
        for place, study in enumerate(matched):
            spread = (np.arange(len(study.error_counts)) / len(study.error_counts) - 0.5) * 0.6
            right.plot(place + spread, study.error_counts, ".", color=AFTER, ms=3)
        right.axhspan(-0.5, 0.5, color=AFTER, alpha=0.1, lw=0)
        right.set_xticks(range(len(names)), names)
        right.set(xlabel="speed, r/s", ylabel="captured less true angle, counts", ylim=(-1.1, 1.1))
        right.set_title("Left once the strobe delay is set", loc="left")
        for axes in (left, right):
            axes.grid(alpha=0.25)
            axes.spines[["top", "right"]].set_visible(False)
        file = io.BytesIO()
        figure.savefig(file, format="svg", metadata={"Date": None})
        return file.getvalue()


def main(rom_path: str) -> None:
    """Run the study and write the plot."""
    write_bytes(PLOT, delay_plot(delay_study(load_rom(Path(rom_path)), DEFAULT_BUILD_FOLDER)))


if __name__ == "__main__":
    main(*sys.argv[1:])
