"""The values that a run file states under the keys of `metadata_keys`."""

import math

from arcref.calibration.metadata_keys import KEYS_BY_NAME
from arcref.run_file import RunFile

LARGEST_STATED = 1e6
"""No number that a run file states is larger."""


def stated_number(run: RunFile, name: str) -> float | None:
    """The number that `run` states under the key `name`, or None when it does not.

    Raises `InputError` when what stands there is no finite number, below the key's least, or absurdly large.
    """
    text = run.metadata.get(name)
    if text is None or not text.strip():
        return None
    key = KEYS_BY_NAME[name]
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    shown = text if len(text) <= 40 else text[:37] + "..."
    if "; " in text:
        raise run.metadata_error(name, f"stated more than once ({shown}), one line was expected")
    if not math.isfinite(value):
        raise run.metadata_error(name, f"{shown!r} is not a finite number ({key.unit} expected)")
    if value < key.lowest:
        raise run.metadata_error(name, f"{shown} is below {key.lowest:g}, the least that can be")
    if abs(value) > LARGEST_STATED:
        raise run.metadata_error(name, f"{shown} is beyond {LARGEST_STATED:g}, more than can be")
    return value


def stated_plus_or_minus_one(run: RunFile, key: str) -> int | None:
    """What stands under `key`, None for nothing. Raises `InputError` for anything but +1 and -1."""
    value = stated_number(run, key)
    if value is not None and abs(value) != 1:
        raise run.metadata_error(key, f"{value:g}, +1 or -1 was expected")
    return None if value is None else int(value)


def stated_standard_uncertainty(run: RunFile, name: str, expanded_name: str) -> float | None:
    """A standard uncertainty that may be stated as such (`name`) or as an expanded one with k=2 (`expanded_name`).

    Raises `InputError` when both stand in the file.
    """
    standard, expanded = stated_number(run, name), stated_number(run, expanded_name)
    if standard is not None and expanded is not None:
        raise run.metadata_error(expanded_name, f"{name} stands here too, one of them was expected")
    return standard if expanded is None else expanded / 2
