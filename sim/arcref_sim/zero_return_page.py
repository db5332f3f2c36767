"""The page that a zero-return test leaves: its figures, its plots and where they come from, in one HTML file."""

from importlib.metadata import version

from jinja2 import Environment, PackageLoader, StrictUndefined

from arcref.angle import ARCSEC_PER_COUNT
from arcref_gateware.reference_encoder import LATENCY_CLOCKS
from arcref_sim.zero_return import WORD_CLOCK_HZ, ZeroReturnResult
from arcref_sim.zero_return_figures import figures
from arcref_sim.zero_return_plots import closure_plot, error_plot, waveform_plot


def zero_return_page(result: ZeroReturnResult) -> str:
    """The page as HTML text. It loads nothing from outside."""
    environment = Environment(
        loader=PackageLoader("arcref_sim", "templates"), autoescape=True, undefined=StrictUndefined, trim_blocks=True
    )
    plan = result.plan
    provenance = {
        "ROM image": f"CRC-32 0x{plan.rom.crc32:08X}",
        "encoder": str(plan.rom.provenance.get("encoder_serial") or "no serial number stated"),
        "core": f"{plan.samples_per_word} samples a word, word clock {WORD_CLOCK_HZ / 1e6:.0f} MHz, "
        f"latency {LATENCY_CLOCKS} clocks",
        "compared with": "the golden model, at every word"
        + ("" if result.first_difference is None else f"; first difference at {result.first_difference}"),
        "arcref": version("arcref"),
    }
    return environment.get_template("zero_return.html.j2").render(
        result=result,
        plan=plan,
        rows=figures(result),
        provenance=provenance,
        arcsec_per_count=ARCSEC_PER_COUNT,
        closure_plot=closure_plot(result),
        error_plot=error_plot(result),
        waveform_plot=waveform_plot(plan),
    )
