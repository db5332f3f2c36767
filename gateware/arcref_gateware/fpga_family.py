"""Which FPGA a platform builds for, where a block takes another form on it."""


def is_ecp5(platform) -> bool:
    """Whether `platform` builds for an ECP5 (LFE5U, LFE5UM, LFE5UM5G)."""
    return _device(platform).startswith("LFE5U")


def is_ice40(platform) -> bool:
    """Whether `platform` builds for an iCE40."""
    return _device(platform).startswith("ICE40")


def is_short_of_registers(platform) -> bool:
    """Whether `platform` builds for an UP5K. An HX8K is short of block RAM, and an ECP5 of neither."""
    return _device(platform).startswith("ICE40UP")


def _device(platform) -> str:
    return str(getattr(platform, "device", "")).upper()
