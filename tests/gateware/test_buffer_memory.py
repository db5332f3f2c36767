# amaranth: UnusedElaboratable=no
"""The buffer memory: every form of it is the same memory, and needs no more block RAM than it should."""

import json
import os
import subprocess
from types import SimpleNamespace

import numpy as np
import pytest
from amaranth.back import verilog
from amaranth.hdl import Elaboratable, Fragment
from amaranth_bench import Bench, assert_rows
from block_ram_model import BlockRamModel

from arcref_gateware import table_memory
from arcref_gateware.buffer_memory import READ_CLOCKS, BufferMemory
from arcref_gateware.toolchain import use_installed_yosys

ECP5 = SimpleNamespace(device="LFE5U-25F")
ICE40 = SimpleNamespace(device="iCE40UP5K")
PORTS = ["write", "write_address", "write_data", "read_address"]
SHAPES = [(8, 256), (16, 256), (16, 1024), (20, 512), (7, 4096), (1, 2)]


class OnPlatform(Elaboratable):
    """A memory as it is made for a platform."""

    def __init__(self, memory, platform):
        self.memory, self.platform = memory, platform
        for name in (*PORTS, "read_data"):
            setattr(self, name, getattr(memory, name))

    def elaborate(self, _):
        return Fragment.get(self.memory, self.platform)


@pytest.mark.parametrize("platform", [None, ICE40, ECP5])
@pytest.mark.parametrize(("width", "depth"), SHAPES)
def test_random_writes_and_reads_in_every_form(platform, width, depth, monkeypatch, rng):
    made = []

    def place(kind, **arguments):
        made.append(BlockRamModel(kind, **arguments))
        return made[-1]

    monkeypatch.setattr(table_memory, "Instance", place)
    clocks = 2000
    init = rng.integers(0, 1 << width, depth // 2)
    near = rng.integers(0, min(depth, 6), clocks)  # few places, so that many are read soon after they were written
    far = rng.integers(0, depth, clocks)
    write_address = np.where(rng.random(clocks) < 0.5, near, far)
    read_address = np.where(rng.random(clocks) < 0.5, near[::-1], far[::-1])
    write, write_data = rng.integers(0, 2, clocks), rng.integers(0, 1 << width, clocks)
    bench = Bench(OnPlatform(BufferMemory(width, depth, init), platform), PORTS, ["read_data"])
    got = bench.run(
        clocks + READ_CLOCKS,
        write=write,
        write_address=write_address,
        write_data=write_data,
        read_address=read_address,
    )["read_data"][READ_CLOCKS:]
    words, expected = [*init.tolist(), *[0] * (depth - depth // 2)], []
    for clock in range(clocks):
        expected.append(words[read_address[clock]])
        if write[clock]:
            words[write_address[clock]] = int(write_data[clock])
    told = (write == 0) | (write_address != read_address)
    assert np.count_nonzero(told) > clocks // 4
    assert_rows("word", got[told], np.array(expected)[told])
    assert bool(made) == (platform is ECP5)
    assert all(ram.parameters["REGMODE_B"] == "OUTREG" for ram in made)


def test_initial_words_that_do_not_fit_are_refused():
    for init in ([1 << 8], [-1], [0] * 17):
        with pytest.raises(ValueError, match="do not fit"):
            BufferMemory(8, 16, init)


@pytest.mark.parametrize(("width", "rams"), [(8, 1), (16, 1), (20, 2)])
def test_an_ice40_takes_one_block_ram_for_sixteen_bits_and_no_collision_logic(width, rams, tmp_path):
    use_installed_yosys()
    memory = BufferMemory(width, 256)
    ports = [getattr(memory, name) for name in (*PORTS, "read_data")]
    (tmp_path / "memory.v").write_text(verilog.convert(memory, name="top", ports=ports, platform=ICE40))
    script = "read_verilog memory.v; synth_ice40 -top top -json memory.json"
    subprocess.run([os.environ["YOSYS"], "-q", "-p", script], cwd=tmp_path, check=True)
    cells = json.loads((tmp_path / "memory.json").read_text())["modules"]["top"]["cells"].values()
    kinds = [cell["type"] for cell in cells]
    assert kinds.count("SB_RAM40_4K") == rams
    # The registers behind it, and what makes them begin with 0.
    assert len(kinds) - rams <= width + 3 * rams
