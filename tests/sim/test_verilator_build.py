"""Finding the tools, and keeping what was built."""

import os
import stat

import pytest

from arcref.input_error import InputError
from arcref_gateware.reference_encoder import ReferenceEncoder
from arcref_sim import verilator_build
from arcref_sim.simulation_top import RESTING_BLOCKS, with_own_clocks
from arcref_sim.verilated_core import CompiledCore


def fake_tool(folder, name, text):
    tool = folder / name
    tool.write_text(f"#!/bin/sh\necho '{text}'\n")
    tool.chmod(tool.stat().st_mode | stat.S_IXUSR)
    return tool


def test_an_old_verilator_is_refused(tmp_path, monkeypatch):
    monkeypatch.setenv("VERILATOR", str(fake_tool(tmp_path, "verilator", "Verilator 5.006 2023-01-22")))
    with pytest.raises(InputError, match=r"5\.006.*5\.036 or newer is needed"):
        verilator_build.verilator_command()


def test_a_verilator_that_does_not_run_is_told(tmp_path, monkeypatch):
    monkeypatch.setenv("VERILATOR", str(tmp_path / "none"))
    with pytest.raises(InputError, match="does not run"):
        verilator_build.verilator_command()


def test_a_new_one_of_the_users_own_is_taken(tmp_path, monkeypatch):
    tool = fake_tool(tmp_path, "verilator", "Verilator 5.100")
    monkeypatch.setenv("VERILATOR", str(tool))
    assert verilator_build.verilator_command()[0] == [str(tool)]


def test_a_missing_compiler_is_told(monkeypatch):
    monkeypatch.setenv("CXX", "no-such-compiler")
    with pytest.raises(InputError, match="set CXX"):
        verilator_build.compiler_command()


def test_a_failing_build_leaves_nothing(compiled, tmp_path):
    description = compiled(4, False).description
    with pytest.raises(verilator_build.BuildError, match="verilator"):
        verilator_build.build_core("module broken(", description, tmp_path, plain=True)
    assert list(tmp_path.iterdir()) == []


def test_the_second_build_is_the_first(compiled, rom):
    first = compiled(4, False).library
    before = os.stat(first).st_mtime_ns
    again = CompiledCore.of(ReferenceEncoder(rom, 4), first.parents[1]).library
    assert again == first
    assert os.stat(again).st_mtime_ns == before


def test_a_core_without_the_resting_blocks_is_refused():
    with pytest.raises(ValueError, match=f"0 blocks {RESTING_BLOCKS[0]}"):
        with_own_clocks("module arcref_core(clk);\n  input clk;\nendmodule\n")
