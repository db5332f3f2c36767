"""Where a calibration comes from, as CAL.json, the report and later the ROM keep it."""

from arcref import __version__
from arcref.run_file import RunFile


def calibration_provenance(method: dict, *runs: RunFile) -> dict:
    """Serial, date and operator of the first run, the method's name and numbers, every run with its SHA-256.

    It depends on the inputs alone, never on the clock, so that the same run gives the same calibration.
    """
    metadata = runs[0].metadata
    return {
        "encoder_serial": metadata.get("encoder_serial"),
        "date": metadata.get("date"),
        "operator": metadata.get("operator"),
        "method": method,
        "inputs": [run.file.record | {"metadata": run.metadata} for run in runs],
        "arcref_version": __version__,
    }
