"""The options by which every verb of the instrument finds it, and the instrument itself."""

from collections.abc import Callable
from functools import wraps

import click

from arcref.instrument.encoder import Encoder
from arcref.link.port_finder import DEFAULT_BAUD, PORT_VARIABLE


def with_encoder(verb: Callable) -> Callable:
    """Give a verb the options `--port` and `--baud`, and an open `Encoder` as its first argument."""

    @click.option(
        "--port", metavar="P", help=f"Serial port.  [default: {PORT_VARIABLE}, or the only instrument plugged in]"
    )
    @click.option("--baud", type=click.IntRange(min=1), default=DEFAULT_BAUD, show_default=True, help="Its speed.")
    @wraps(verb)
    def opened(port, baud, **options):
        with Encoder(port, baud=baud) as encoder:
            return verb(encoder, **options)

    return opened
