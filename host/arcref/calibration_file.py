"""Reading calibration results, `CAL.json`: format, version, kind, the error curve and where it comes from."""

import json
import math
from dataclasses import dataclass, field

import numpy as np

from arcref.input_error import InputError
from arcref.input_file import InputFile, read_input_file

FORMAT = "arcref-calibration"
VERSION = 1
KINDS = ("polygon", "closure", "theodolite", "subdivision")


@dataclass(frozen=True, eq=False)
class CalibrationFile:
    """A calibration result.

    `angle_deg`: float64[n], degrees of the turn, or for kind subdivision degrees of one grating line (`line_deg` in
    the file); `error_arcsec`: float64[n]; `u_arcsec`: standard uncertainty (k=1), float64[n], or None when not stated;
    `arc_deg`: (first, last) angle of the arc that was measured, None when the file names none.
    """

    file: InputFile
    kind: str
    angle_deg: np.ndarray
    error_arcsec: np.ndarray
    u_arcsec: np.ndarray | None
    results: dict = field(repr=False)
    provenance: dict = field(repr=False)
    arc_deg: tuple[float, float] | None = None


def read_calibration(path, kinds: tuple[str, ...] = KINDS) -> CalibrationFile:
    """Read a calibration of one of `kinds`.

    Raises `InputError` when it cannot be read, is of another format, version or kind, or its curve is not three lists
    of the same length of finite numbers, with no uncertainty below zero.
    """
    file = read_input_file(path)
    content = file.json_object()
    for key, expected in (("format", (FORMAT,)), ("version", (VERSION,)), ("kind", kinds)):
        value = content.get(key)
        if value not in expected or isinstance(value, bool):
            wanted = " or ".join(repr(choice) for choice in expected)
            raise InputError.at(path, f"is {_short(value)}, {wanted} was expected", column=key)
    for key in ("results", "provenance"):
        if not isinstance(content.setdefault(key, {}), dict):
            raise InputError.at(path, f"is {_short(content[key])}, a JSON object was expected", column=key)
        try:
            json.dumps(content[key], allow_nan=False)
        except ValueError:
            raise InputError.at(path, "holds a number that is not finite", column=key) from None
    curve = content.get("curve")
    if not isinstance(curve, dict):
        raise InputError.at(path, f"is {_short(curve)}, a JSON object was expected", column="curve")
    angle = _numbers(path, curve, "line_deg" if content["kind"] == "subdivision" else "angle_deg")
    error = _numbers(path, curve, "error_arcsec", len(angle))
    u = None if curve.get("u_arcsec") is None else _numbers(path, curve, "u_arcsec", len(angle))
    if u is not None and (u < 0).any():
        index = int(np.argmax(u < 0))
        problem = f"is {u[index]:g}, an uncertainty of 0 or more was expected"
        raise InputError.at(path, problem, column=f"curve.u_arcsec[{index}]")
    arc = None if curve.get("arc_deg") is None else _arc(path, curve, angle)
    return CalibrationFile(file, content["kind"], angle, error, u, content["results"], content["provenance"], arc)


def _arc(path, curve: dict, angle_deg: np.ndarray) -> tuple[float, float]:
    first, last = _numbers(path, curve, "arc_deg", 2, "the first and the last angle of the arc")
    if not 0 < last - first < 360:
        problem = f"is {first:g} .. {last:g} deg, an increasing arc of less than a turn was expected"
        raise InputError.at(path, problem, column="curve.arc_deg")
    if angle_deg.size and not first <= angle_deg.min() <= angle_deg.max() <= last:
        problem = f"is {first:g} .. {last:g} deg, which leaves out angles of curve.angle_deg"
        raise InputError.at(path, problem, column="curve.arc_deg")
    return float(first), float(last)


def _numbers(path, curve: dict, key: str, length: int | None = None, what: str = "one for each angle") -> np.ndarray:
    values = curve.get(key)
    if not isinstance(values, list):
        raise InputError.at(path, f"is {_short(values)}, a list of numbers was expected", column=f"curve.{key}")
    if length is not None and len(values) != length:
        problem = f"has {len(values)} numbers, {length} were expected, {what}"
        raise InputError.at(path, problem, column=f"curve.{key}")
    for index, value in enumerate(values):
        if type(value) not in (int, float) or abs(value) > 1e300 or not math.isfinite(value):
            problem = f"is {_short(value)}, a finite number was expected"
            raise InputError.at(path, problem, column=f"curve.{key}[{index}]")
    return np.array(values, float)


def readings_json(readings_deg, weight) -> dict:
    """`readings` of `results`: at which angles each error of the curve was read (NaN: not), and the weights."""
    rows = [[round(float(value), 9) if math.isfinite(value) else None for value in row] for row in readings_deg]
    return {"position_deg": rows, "weight": [float(value) for value in weight]}


def read_readings(path, results: dict, count: int) -> tuple[np.ndarray, np.ndarray] | tuple[None, None]:
    """What `readings_json` wrote: float64[count, m] with NaN, float64[m]; (None, None) when `results` has none.

    Raises `InputError` when it is anything else.
    """
    if results.get("readings") is None:
        return None, None
    try:
        readings = np.array(results["readings"]["position_deg"], float)
        weight = np.array(results["readings"]["weight"], float)
        good = readings.shape == (count, weight.size) and np.isfinite(readings).any(axis=1).all()
        good = good and (weight > 0).all() and (np.abs(readings[np.isfinite(readings)]) < 1e6).all()
    except (KeyError, TypeError, ValueError, IndexError):
        good = False
    if not good:
        problem = f"{count} rows of position_deg, each with a number for each weight above 0, were expected"
        raise InputError.at(path, problem, column="results.readings")
    return readings, weight


def _short(value) -> str:
    """A value out of the file, on one line and not too long for an error message."""
    if value is None:
        return "missing"
    text = repr(value)
    return text if len(text) <= 40 else text[:37] + "..."
