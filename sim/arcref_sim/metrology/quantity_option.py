"""Types of command-line numbers that are refused in one line when they are out of range."""

import math
import re

import click

from arcref.input_error import InputError

_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)


class Quantity(click.ParamType):
    """A finite number from `low` to `high`, both included, in `unit`; whole when `whole` is set."""

    name = "number"

    def __init__(self, unit: str, low: float, high: float, whole: bool = False):
        self.unit, self.low, self.high, self.whole = unit, low, high, whole

    def convert(self, value, param, ctx):
        """The number. Raises `InputError` that names the option, what it is and what was expected."""
        return self.number(param.opts[0], value)

    def number(self, option: str, value) -> float | int:
        """The number that `value` is, for an option or a part of one."""
        text = str(value).strip()
        number = float(text) if _NUMBER.fullmatch(text) else math.nan
        kind = "a whole number" if self.whole else "a number"
        if not self.low <= number <= self.high or (self.whole and number != int(number)):
            unit = f" {self.unit}" if self.unit else ""
            raise InputError(f"{option} is {text!r}, {kind} in {self.low:g} .. {self.high:g}{unit} was expected")
        return int(number) if self.whole else number


class NumberParts(click.ParamType):
    """Numbers with colons between them: one `Quantity` for each part."""

    name = "numbers"

    def __init__(self, *parts: Quantity):
        self.parts = parts

    def convert(self, value, param, ctx):
        """A tuple of the numbers. Raises `InputError` in one line."""
        if isinstance(value, tuple):
            return value
        texts = str(value).split(":")
        if len(texts) != len(self.parts):
            raise InputError(f"{param.opts[0]} is {value!r}, {param.metavar} was expected")
        return tuple(part.number(param.opts[0], text) for part, text in zip(self.parts, texts, strict=True))


class WholeNumbers(click.ParamType):
    """One whole number N, which stands for 1 .. N, or several with commas between them."""

    name = "numbers"

    def __init__(self, low: int, high: int):
        self.one = Quantity("", low, high, whole=True)

    def convert(self, value, param, ctx):
        """A tuple of different numbers as given. Raises `InputError` in one line."""
        if isinstance(value, tuple):
            return value
        option, texts = param.opts[0], str(value).split(",")
        numbers = tuple(self.one.number(option, text) for text in texts)
        if len(set(numbers)) < len(numbers):
            raise InputError(f"{option} is {value!r}, each number was expected once")
        return numbers if len(numbers) > 1 else tuple(range(1, numbers[0] + 1))
