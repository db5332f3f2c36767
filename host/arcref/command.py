"""The command `arcref`.

Exit status: 0 done, 1 the instrument or a test failed its check, 2 bad input or use.

Verbs of the host are listed here; the floors above add theirs through the entry-point group `arcref.commands`. A verb
is imported when it is used and not before, so that `arcref --help` is quick and needs no optional package.
"""

import ast
import os
import sys
from importlib import import_module
from importlib.metadata import entry_points, requires
from importlib.util import find_spec
from pathlib import Path

import click

from arcref.input_error import InputError
from arcref.instrument_error import InstrumentError

ENTRY_POINT_GROUP = "arcref.commands"

HOST_VERBS = {
    "rom": "arcref.rom_command:rom",
    "info": "arcref.instrument.info_command:info",
    "read": "arcref.instrument.read_command:read",
    "capture": "arcref.instrument.capture_command:capture",
    "watch": "arcref.instrument.watch_command:watch",
    "zero-return": "arcref.instrument.zero_return_command:zero_return",
    "registers": "arcref.instrument.registers_command:registers",
    "compare": "arcref.comparison.compare_command:compare",
}
"""Verbs of the host: name and `module:function`."""

INTERRUPTED = 130
"""Exit status after Ctrl-C, as shells have it."""


class BadInput(click.ClickException):
    """An `InputError` as click shows it: one line, exit status 2."""

    exit_code = 2

    def show(self, file=None):
        """Print the line on stderr."""
        # A file name may hold a line break; the message stays one line.
        click.echo("arcref: " + " ".join(self.message.splitlines()), file=file, err=file is None)


class InstrumentFailed(BadInput):
    """An `InstrumentError` as click shows it: one line, exit status 1."""

    exit_code = 1


class VerbGroup(click.Group):
    """A group whose verbs are loaded when they are used."""

    def list_commands(self, ctx):
        """Names of all verbs, sorted."""
        return sorted(_targets())

    def get_command(self, ctx, cmd_name):
        """Load one verb. Raises `InputError` when a package it needs is not installed."""
        target = _targets().get(cmd_name)
        if target is None:
            return None
        module, _, function = target.partition(":")
        try:
            return getattr(import_module(module), function)
        except ModuleNotFoundError as error:
            raise BadInput(_missing_package(cmd_name, error)) from error

    def format_commands(self, ctx, formatter):
        """The verbs with the first line of their help, read from the source without importing it."""
        with formatter.section("Commands"):
            formatter.write_dl([(name, _first_line(target)) for name, target in sorted(_targets().items())])

    def invoke(self, ctx):
        """Run a verb and give bad input and Ctrl-C their exit status."""
        try:
            return super().invoke(ctx)
        except InputError as error:
            raise BadInput(str(error)) from error
        except InstrumentError as error:
            raise InstrumentFailed(str(error)) from error
        except ModuleNotFoundError as error:
            if _extra_of(error.name) is None:
                raise
            raise BadInput(_missing_package(ctx.invoked_subcommand, error)) from error
        except KeyboardInterrupt:
            click.echo("arcref: interrupted", err=True)
            ctx.exit(INTERRUPTED)
        except BrokenPipeError:
            # The reader, `head` for instance, has seen enough. Nothing more can be written, nor need it be.
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            ctx.exit(0)


@click.group("arcref", cls=VerbGroup, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="arcref", prog_name="arcref")
def main():
    """Tools of arcref, the open 23-bit reference angle encoder."""


def _targets() -> dict[str, str]:
    """Every verb and its `module:function`. A verb of the host cannot be replaced from outside."""
    return {entry.name: entry.value for entry in entry_points(group=ENTRY_POINT_GROUP)} | HOST_VERBS


def _first_line(target: str) -> str:
    """The first line of a verb's docstring, "" when it cannot be found."""
    module, _, function = target.partition(":")
    top, *rest = module.split(".")
    try:
        # Only the top package is looked for: to look for a module inside it would import the package.
        spec = find_spec(top)
        places = [Path(folder, *rest).with_suffix(".py") for folder in spec.submodule_search_locations]
        tree = ast.parse(next(place for place in places if place.is_file()).read_text(encoding="utf-8"))
    except (AttributeError, ImportError, OSError, StopIteration, SyntaxError, ValueError):
        return ""
    for node in tree.body:
        if isinstance(node, ast.FunctionDef) and node.name == function:
            return (ast.get_docstring(node) or "").partition("\n")[0]
    return ""


def _missing_package(verb: str, error: ModuleNotFoundError) -> str:
    extra = _extra_of(error.name)
    if extra is None:
        return f"the verb {verb!r} cannot be loaded: {error}"
    return f"the verb {verb!r} needs the package {error.name.partition('.')[0]!r}: install arcref[{extra}]"


def _extra_of(module: str | None) -> str | None:
    """The optional part of arcref that brings `module`, read from its own package metadata; None when none does."""
    package = (module or "").partition(".")[0].replace("_", "-").lower()
    for requirement in requires("arcref") or ():
        name, _, condition = requirement.partition(";")
        if name.strip().lower() == package and "extra ==" in condition:
            return condition.partition("extra ==")[2].strip(" '\"")
    return None


if __name__ == "__main__":
    main(prog_name="arcref")
