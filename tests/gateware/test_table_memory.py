"""Tables in block RAM: the generic form and the ECP5 form are the same memory, and both hold what they were given."""

import json
import os
import re
import subprocess
from types import SimpleNamespace

import numpy as np
import pytest
from amaranth.back import verilog
from amaranth.hdl import Elaboratable, Fragment
from amaranth_bench import Bench, assert_rows
from block_ram_model import LOWEST_ADDRESS_LINE, BlockRamModel, initial_rows, word_at

from arcref.rom_identity import identity_words
from arcref_gateware import table_memory
from arcref_gateware.fpga_family import is_ecp5
from arcref_gateware.reference_encoder import ReferenceEncoder
from arcref_gateware.table_contents import TableContents, placeholder_contents, rom_contents
from arcref_gateware.table_memory import TABLE_CLOCKS, TableMemory, initial_values
from arcref_gateware.toolchain import use_installed_yosys
from arcref_gateware.verilog_export import export_verilog

ECP5 = SimpleNamespace(device="LFE5U-25F")
ICE40 = SimpleNamespace(device="iCE40HX8K")
DEPTHS = [64, 512, 1024, 2048, 4096]


class OnPlatform(Elaboratable):
    """A table as it is made for a platform."""

    def __init__(self, table: TableMemory, platform):
        self.table, self.platform = table, platform
        self.address, self.data = table.address, table.data
        self.write, self.write_data = table.write, table.write_data

    def elaborate(self, _):
        return Fragment.get(self.table, self.platform)


def read(words, platform, address):
    """What the table gives, clock by clock, `TABLE_CLOCKS` clocks taken off."""
    bench = Bench(OnPlatform(TableMemory(words), platform), ["address"], ["data"])
    return bench.run(len(address) + TABLE_CLOCKS, address=address)["data"][TABLE_CLOCKS:]


@pytest.mark.parametrize("platform", [None, ICE40, ECP5])
@pytest.mark.parametrize("depth", DEPTHS)
def test_every_word_comes_after_its_clocks_in_every_form(platform, depth, monkeypatch, rng):
    made = []

    def place(kind, **arguments):
        made.append(BlockRamModel(kind, **arguments))
        return made[-1]

    monkeypatch.setattr(table_memory, "Instance", place)
    words = rng.integers(0, 1 << 16, depth)
    address = np.concatenate((rng.permutation(depth), rng.integers(0, depth, 200)))
    assert_rows("word", read(words, platform, address), words[address])
    assert len(made) == (0 if platform is not ECP5 else 1 if depth <= 1024 else 4)
    assert all(ram.parameters["REGMODE_A"] == "OUTREG" for ram in made)


@pytest.mark.parametrize("platform", [None, ECP5])
@pytest.mark.parametrize("depth", [512, 4096])
def test_a_table_is_written_in_every_form(platform, depth, monkeypatch, rng):
    monkeypatch.setattr(table_memory, "Instance", BlockRamModel)
    words, written = rng.integers(0, 1 << 16, depth), rng.integers(0, 1 << 16, 300)
    places = rng.integers(0, depth, 300)
    bench = Bench(OnPlatform(TableMemory(words), platform), ["address", "write", "write_data"], ["data"])
    address = np.concatenate((places, places, np.arange(depth)))
    write = np.repeat([1, 0], [300, 300 + depth])
    data = bench.run(len(address) + TABLE_CLOCKS, address=address, write=write, write_data=written)["data"]
    words[places] = written  # the last one that went to a place
    assert_rows("word", data[TABLE_CLOCKS + 300 :], words[address[300:]])


def test_a_table_larger_than_four_block_rams_is_left_to_synthesis(rng):
    words = rng.integers(0, 1 << 16, 8192)
    address = rng.integers(0, 8192, 50)
    assert_rows("word", read(words, ECP5, address), words[address])


@pytest.mark.parametrize("name", ["LFE5U-12F", "LFE5U-85F", "LFE5UM-25F", "LFE5UM5G-45F"])
def test_every_ecp5_is_one(name):
    assert is_ecp5(SimpleNamespace(device=name))


@pytest.mark.parametrize("platform", [None, ICE40, SimpleNamespace(), SimpleNamespace(device="LIFCL-40")])
def test_nothing_else_is(platform):
    assert not is_ecp5(platform)


@pytest.mark.parametrize(("width", "depth"), [(18, 512), (4, 4096)])
def test_the_contents_lie_where_synthesis_puts_them(width, depth, tmp_path, rng):
    """Yosys maps the generic form to the same block RAM: its parameters and address lines, read with the same model."""
    use_installed_yosys()
    words = rng.integers(0, 1 << 16, depth).tolist()
    table = TableMemory(words)
    (tmp_path / "table.v").write_text(verilog.convert(table, name="top", ports=[table.address, table.data]))
    script = "read_verilog table.v; synth_ecp5 -top top -json table.json"
    subprocess.run([os.environ["YOSYS"], "-q", "-p", script], cwd=tmp_path, check=True)
    module = json.loads((tmp_path / "table.json").read_text())["modules"]["top"]
    address_net = {net: bit for bit, net in enumerate(module["ports"]["address"]["bits"])}
    rams = [cell for cell in module["cells"].values() if cell["type"] == "DP16KD"]
    assert len(rams) == 16 // min(width, 16)

    columns = []
    for ram in rams:
        assert int(ram["parameters"]["DATA_WIDTH_A"], 2) == width
        nets = [ram["connections"][f"ADA{line}"][0] for line in range(14)]
        lines = [address_net[net] for net in nets if net in address_net]
        low = LOWEST_ADDRESS_LINE[width]
        assert lines == list(range(len(lines)))
        assert nets.index(next(net for net in nets if address_net.get(net) == 0)) == low
        values = {name: int(value, 2) for name, value in ram["parameters"].items() if name.startswith("INITVAL_")}
        read_back = [word_at(initial_rows(values), width, address << low) for address in range(depth)]
        columns += [[word >> bit & 1 for word in read_back] for bit in range(width)]
    wanted = {tuple(word >> bit & 1 for word in words) for bit in range(16)}
    assert wanted <= set(map(tuple, columns))

    own = initial_values(width, [word & (1 << width) - 1 for word in words])
    own_rows = initial_rows({name[2:]: value.value for name, value in own.items()})
    assert [word_at(own_rows, width, place << low) for place in range(depth)] == [w & (1 << width) - 1 for w in words]


def test_the_contents_of_a_rom_are_its_words(random_rom):
    contents = rom_contents(random_rom)
    assert contents.line.tolist() == (random_rom.line_table.astype(int) & 0xFFFF).tolist()
    assert contents.subdivision.tolist() == (random_rom.subdivision_table.astype(int) & 0xFFFF).tolist()
    assert contents.identity.tolist() == identity_words(random_rom).tolist()


def test_placeholders_are_the_same_each_time_full_width_and_unlike_each_other():
    placeholder = placeholder_contents()
    assert [len(words) for words in placeholder] == [4096, 512, 512]
    columns = []
    for name, words in zip(TableContents._fields, placeholder, strict=True):
        assert words.tolist() == getattr(placeholder_contents(), name).tolist()
        for block in words.reshape(-1, 256):
            columns += [tuple(block >> bit & 1) for bit in range(16)]
    assert len(set(columns)) == len(columns), "two columns of 256 words are alike"
    assert all(80 < sum(column) < 176 for column in columns)
    # Fixed for good: a bitstream built earlier is patched by looking for these very words.
    assert [hex(words[0]) for words in placeholder] == ["0xdac1", "0xaad3", "0x30ab"]


def test_nothing_but_the_memories_depends_on_the_rom(random_rom):
    """The same netlist, initial words left out."""

    def logic(rom):
        text = export_verilog(ReferenceEncoder(rom, 2))
        words = re.findall(r"memory\[\d+\] = 16'h[0-9a-f]+;", text)
        assert len(words) == 4096 + 512 + 512 + 128, "the tables, and the lines of the strobes that wait"
        return re.sub(r"(memory\[\d+\] =) 16'h[0-9a-f]+;", r"\1", text)

    assert logic(None) == logic(random_rom)
