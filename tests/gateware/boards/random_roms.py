"""ROM images with anything in them."""

import numpy as np

from arcref.correction_rom import CorrectionRom


def random_rom(rng, serial: str = "AR-1") -> CorrectionRom:
    """A ROM with entries all over their range."""
    entries = rng.integers(-32768, 32768, 4096 + 512).astype(np.int16)
    return CorrectionRom(entries[:4096], entries[4096:], {"encoder_serial": serial, "date": "2026-11-23"})
