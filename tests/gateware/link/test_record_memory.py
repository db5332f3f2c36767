"""Records in block RAM: every form is the same memory, and on an iCE40 nothing stands behind it but a register."""

import json
import os
import subprocess
from types import SimpleNamespace

import numpy as np
import pytest
from amaranth.back import rtlil
from amaranth.hdl import Elaboratable, Fragment
from amaranth_bench import Bench, assert_rows
from block_ram_model import BlockRamModel
from ice40_ram_model import Ice40RamModel

from arcref_gateware import table_memory
from arcref_gateware.link import record_memory
from arcref_gateware.link.record_memory import READ_CLOCKS, RECORD_BITS, WORD_BITS, WORDS, RecordMemory
from arcref_gateware.toolchain import use_installed_yosys

ECP5 = SimpleNamespace(device="LFE5U-25F")
ICE40 = SimpleNamespace(device="iCE40HX8K")
PORTS = ["write", "write_record", "record", "read_record", "read_word"]


class OnPlatform(Elaboratable):
    """A memory as it is made for a platform."""

    def __init__(self, memory, platform):
        self.memory, self.platform = memory, platform
        for name in (*PORTS, "word"):
            setattr(self, name, getattr(memory, name))

    def elaborate(self, _):
        return Fragment.get(self.memory, self.platform)


@pytest.mark.parametrize(
    ("platform", "depth", "rams"),
    [
        (None, 256, 0),
        (ICE40, 256, 8),
        (ICE40, 64, 8),
        (ICE40, 512, 0),
        (ECP5, 512, 8),
        (ECP5, 1024, 8),
        (ECP5, 2048, 0),
    ],
)
def test_random_records_are_read_word_by_word_in_every_form(platform, depth, rams, monkeypatch, rng):
    made = []

    def place(model):
        return lambda kind, **arguments: made.append(model(kind, **arguments)) or made[-1]

    monkeypatch.setattr(table_memory, "Instance", place(BlockRamModel))
    monkeypatch.setattr(record_memory, "Instance", place(Ice40RamModel))
    clocks = 3000
    records = [int.from_bytes(rng.bytes(RECORD_BITS // 8), "little") for _ in range(clocks)]
    few = rng.integers(0, 8, clocks) * (depth // 8 + 1) % depth
    write_record = np.where(rng.random(clocks) < 0.7, few, rng.integers(0, depth, clocks))
    read_record = np.where(rng.random(clocks) < 0.9, rng.permutation(write_record), write_record)
    read_word, write = rng.integers(0, WORDS, clocks), rng.integers(0, 2, clocks)
    bench = Bench(OnPlatform(RecordMemory(depth), platform), PORTS, ["word"])
    got = bench.run(
        clocks + READ_CLOCKS,
        write=np.append(write, 0),
        write_record=write_record,
        record=np.array(records, dtype=object),
        read_record=read_record,
        read_word=read_word,
    )["word"][READ_CLOCKS:]
    assert len(made) == rams
    contents, expected = {}, []
    for clock in range(clocks):
        whole = contents.get(read_record[clock], 0)
        expected.append(whole >> WORD_BITS * int(read_word[clock]) & 0xFFFF)
        if write[clock]:
            contents[write_record[clock]] = records[clock]
    told = (write == 0) | (write_record != read_record)
    assert_rows("word", got[told], np.array(expected)[told])


def test_an_ice40_needs_eight_block_rams_and_a_register(tmp_path):
    use_installed_yosys()
    memory = RecordMemory(256)
    ports = [getattr(memory, name) for name in (*PORTS, "word")]
    (tmp_path / "memory.il").write_text(rtlil.convert(memory, name="top", ports=ports, platform=ICE40))
    script = "read_rtlil memory.il; synth_ice40 -top top -json memory.json"
    subprocess.run([os.environ["YOSYS"], "-q", "-p", script], cwd=tmp_path, check=True)
    cells = json.loads((tmp_path / "memory.json").read_text())["modules"]["top"]["cells"].values()
    kinds = sorted({cell["type"] for cell in cells})
    assert kinds in (["SB_DFF", "SB_RAM40_4K"], ["SB_DFFSR", "SB_RAM40_4K"])
    assert len(cells) == 8 + WORD_BITS
