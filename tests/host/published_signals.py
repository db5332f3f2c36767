"""The signals of Gao Xu et al., Acta Optica Sinica 33(7) 2013 0712001, Table 1, and what the paper prints of them."""

import csv
from pathlib import Path

from arcref.subdivision.signal_model import ChannelModel, Harmonic, SignalModel

EXAMPLES = Path(__file__).parents[2] / "examples"

LINE_COUNT = 16384

PRINTED_BEFORE_ARCSEC, PRINTED_AFTER_ARCSEC = 0.923, 0.316


def _rows(name: str) -> list[dict]:
    lines = (EXAMPLES / name).read_text(encoding="utf-8").splitlines()
    return list(csv.DictReader(line for line in lines if not line.startswith("#")))


def _channel(row: dict) -> ChannelModel:
    waves = {k: Harmonic(float(row[f"A{k}_V"]), float(row[f"c{k}_rad"])) for k in (1, 3, 5)}
    return ChannelModel(float(row["A0_V"]), waves)


def published_signals(line_count: int = LINE_COUNT) -> SignalModel:
    """Table 1 as printed: negative amplitudes and a phase beyond a turn included."""
    sine, cosine = (_channel(row) for row in _rows("subdivision_waveform_parameters.csv"))
    return SignalModel(sine, cosine, line_count)


def printed_peak_to_peak() -> dict[str, float]:
    """State ("before", "after") to the printed error, arcsec peak to peak."""
    rows = _rows("subdivision_published_results.csv")
    return {row["state"]: float(row["peak_to_peak_arcsec"]) for row in rows}
