"""The options by which every verb of the instrument finds it, and the instrument itself."""

from collections.abc import Callable
from functools import wraps
from pathlib import Path

import click

from arcref.instrument.encoder import Encoder
from arcref.link.packet import DEFAULT_BAUD
from arcref.link.port_finder import PORT_VARIABLE

FASTEST_BAUD = 2**31 - 1
"""What the system's call for the speed of a port can take."""

JSON_FILE = click.Path(path_type=Path)
"""A file for the figures of a verb."""


class Seconds(click.FloatRange):
    """A time in seconds, finite and 0 or more."""

    def convert(self, value, param, ctx):
        """The number. click lets "nan" through, which lies in no range."""
        number = super().convert(value, param, ctx)
        if number != number:
            self.fail(f"{value} is not in the range {self._describe_range()}.", param, ctx)
        return number


SECONDS = Seconds(0, 1e9)


def with_encoder(verb: Callable) -> Callable:
    """Give a verb the options `--port` and `--baud`, and an open `Encoder` as its first argument."""

    @click.option(
        "--port", metavar="P", help=f"Serial port.  [default: {PORT_VARIABLE}, or the only instrument plugged in]"
    )
    @click.option(
        "--baud", type=click.IntRange(1, FASTEST_BAUD), default=DEFAULT_BAUD, show_default=True, help="Its speed."
    )
    @wraps(verb)
    def opened(port, baud, **options):
        with Encoder(port, baud=baud) as encoder:
            return verb(encoder, **options)

    return opened
