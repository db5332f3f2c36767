"""Groups of verbs that are imported when they are used and not before.

So `--help` is quick and needs no optional package: the first line of each verb's help is read from its source.
"""

import ast
from collections.abc import Callable, Mapping
from importlib import import_module
from importlib.metadata import requires
from importlib.util import find_spec
from pathlib import Path

import click


class BadInput(click.ClickException):
    """An `InputError` as click shows it: one line, exit status 2."""

    exit_code = 2

    def show(self, file=None):
        """Print the line on stderr."""
        # A file name may hold a line break; the message stays one line.
        click.echo("arcref: " + " ".join(self.message.splitlines()), file=file, err=file is None)


class VerbGroup(click.Group):
    """A group whose verbs are loaded when they are used.

    `targets`: the name of each verb and its `module:function`, or a function that gives them. The function must be
    defined in that module and be a click command.
    """

    def __init__(self, *arguments, targets: Mapping[str, str] | Callable[[], Mapping[str, str]] = (), **options):
        super().__init__(*arguments, **options)
        self._targets = targets

    @property
    def targets(self) -> dict[str, str]:
        """Every verb and its `module:function`."""
        return dict(self._targets() if callable(self._targets) else self._targets)

    def list_commands(self, ctx):
        """Names of all verbs, sorted."""
        return sorted(self.targets)

    def get_command(self, ctx, cmd_name):
        """Load one verb. Raises `BadInput` when a package it needs is not installed."""
        target = self.targets.get(cmd_name)
        if target is None:
            return None
        module, _, function = target.partition(":")
        try:
            return getattr(import_module(module), function)
        except ModuleNotFoundError as error:
            raise BadInput(missing_package(cmd_name, error)) from error

    def format_commands(self, ctx, formatter):
        """The verbs with the first line of their help, read from the source without importing it."""
        with formatter.section("Commands"):
            formatter.write_dl([(name, first_line(target)) for name, target in sorted(self.targets.items())])


def first_line(target: str) -> str:
    """The first line of the docstring of a verb's `module:function`, "" when it cannot be found."""
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


def missing_package(verb: str, error: ModuleNotFoundError) -> str:
    """The line for a verb that cannot be loaded: which package it needs, and what brings it."""
    extra = extra_of(error.name)
    if extra is None:
        return f"the verb {verb!r} cannot be loaded: {error}"
    return f"the verb {verb!r} needs the package {error.name.partition('.')[0]!r}: install arcref[{extra}]"


def extra_of(module: str | None) -> str | None:
    """The optional part of arcref that brings `module`, read from its own package metadata; None when none does."""
    package = (module or "").partition(".")[0].replace("_", "-").lower()
    for requirement in requires("arcref") or ():
        name, _, condition = requirement.partition(";")
        if name.strip().lower() == package and "extra ==" in condition:
            return condition.partition("extra ==")[2].strip(" '\"")
    return None
