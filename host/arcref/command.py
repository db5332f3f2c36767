"""The command `arcref`.

Exit status: 0 done, 1 the instrument or a test failed its check, 2 bad input or use.

Verbs of the host are listed here; the floors above add theirs through the entry-point group `arcref.commands`. A verb
is imported when it is used and not before, so that `arcref --help` is quick and needs no optional package.
"""

import os
import sys
from importlib.metadata import entry_points

import click

from arcref.input_error import InputError
from arcref.instrument_error import InstrumentError
from arcref.verb_group import BadInput, VerbGroup, extra_of, missing_package

ENTRY_POINT_GROUP = "arcref.commands"

HOST_VERBS = {
    "calibrate": "arcref.calibration.calibrate_command:calibrate",
    "rom": "arcref.rom_command:rom",
    "info": "arcref.instrument.info_command:info",
    "read": "arcref.instrument.read_command:read",
    "capture": "arcref.instrument.capture_command:capture",
    "watch": "arcref.instrument.watch_command:watch",
    "monitor": "arcref.instrument.watch_command:monitor",
    "zero-return": "arcref.instrument.zero_return_command:zero_return",
    "registers": "arcref.instrument.registers_command:registers",
    "trial": "arcref.instrument.trial_command:trial",
    "compare": "arcref.comparison.compare_command:compare",
}
"""Verbs of the host: name and `module:function`."""

INTERRUPTED = 130
"""Exit status after Ctrl-C, as shells have it."""


class InstrumentFailed(BadInput):
    """An `InstrumentError` as click shows it: one line, exit status 1."""

    exit_code = 1


class MainGroup(VerbGroup):
    """The command itself: bad input, Ctrl-C and a reader that has gone get their exit status here, for every verb."""

    def invoke(self, ctx):
        """Run a verb and give bad input and Ctrl-C their exit status."""
        try:
            return super().invoke(ctx)
        except InputError as error:
            raise BadInput(str(error)) from error
        except InstrumentError as error:
            raise InstrumentFailed(str(error)) from error
        except ModuleNotFoundError as error:
            if extra_of(error.name) is None:
                raise
            raise BadInput(missing_package(ctx.invoked_subcommand, error)) from error
        except KeyboardInterrupt:
            click.echo("arcref: interrupted", err=True)
            ctx.exit(INTERRUPTED)
        except BrokenPipeError:
            # The reader, `head` for instance, has seen enough. Nothing more can be written, nor need it be.
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            ctx.exit(0)


def all_verbs() -> dict[str, str]:
    """Every verb and its `module:function`. A verb of the host cannot be replaced from outside."""
    return {entry.name: entry.value for entry in entry_points(group=ENTRY_POINT_GROUP)} | HOST_VERBS


@click.group("arcref", cls=MainGroup, targets=all_verbs, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="arcref", prog_name="arcref")
def main():
    """Tools of arcref, the open 23-bit reference angle encoder."""


if __name__ == "__main__":
    main(prog_name="arcref")
