"""Host tools of arcref, the open 23-bit reference angle encoder.

The names below are the public ones. Each is loaded when it is first used, so that `arcref --help` is quick.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from arcref.correction_rom import CorrectionRom
    from arcref.error_curve import ErrorCurve
    from arcref.flags import Flag
    from arcref.input_error import InputError
    from arcref.instrument.encoder import Encoder
    from arcref.instrument_error import InstrumentError
    from arcref.position_frame import PositionFrame
    from arcref.radial_basis_network import RadialBasisNetwork
    from arcref.rom_image import load_rom, save_rom

    __version__: str

__all__ = [
    "CorrectionRom",
    "Encoder",
    "ErrorCurve",
    "Flag",
    "InputError",
    "InstrumentError",
    "PositionFrame",
    "RadialBasisNetwork",
    "__version__",
    "load_rom",
    "save_rom",
]

_HOME = {
    "CorrectionRom": "arcref.correction_rom",
    "Encoder": "arcref.instrument.encoder",
    "ErrorCurve": "arcref.error_curve",
    "Flag": "arcref.flags",
    "InputError": "arcref.input_error",
    "InstrumentError": "arcref.instrument_error",
    "PositionFrame": "arcref.position_frame",
    "RadialBasisNetwork": "arcref.radial_basis_network",
    "load_rom": "arcref.rom_image",
    "save_rom": "arcref.rom_image",
}


def __getattr__(name: str):
    if name == "__version__":
        from importlib.metadata import version

        value = version("arcref")
    elif name in _HOME:
        value = getattr(import_module(_HOME[name]), name)
    else:
        raise AttributeError(f"module 'arcref' has no attribute {name!r}")
    globals()[name] = value
    return value
