"""What the tests of boards share: bitstreams as `arcref build` leaves them, made without place and route."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from packed_tables import BUILT_BOARDS, pack
from random_roms import random_rom

from arcref.command import main
from arcref.correction_rom import CorrectionRom
from arcref.rom_image import save_rom
from arcref_gateware.boards.bitstream import board_comment
from arcref_gateware.boards.bitstream_tables import locate_tables, read_bitstream
from arcref_gateware.boards.build_record import FORMAT, VERSION, record_json, with_rom
from arcref_gateware.boards.table_layout import place_tables
from arcref_gateware.table_contents import placeholder_contents, rom_contents

CONSTRAINTS = Path(__file__).parents[3] / "constraints"


@pytest.fixture(scope="session")
def leave_built(tmp_path_factory):
    """Leaves in a folder what `arcref build` would: `leave_built(folder, board, rom)` gives the bitstream's path.

    Without a ROM it holds the placeholder. `layout` chooses between layouts that differ in the places of the tables.
    """

    @cache
    def packed(board: str, layout: int):
        device, family, _ = BUILT_BOARDS[board]
        place = tmp_path_factory.mktemp("packed")
        rng = np.random.default_rng(layout)
        content, bitstream_class, _ = pack(place, device, rng, placeholder_contents(), board_comment(board))
        return content, locate_tables(bitstream_class(content), family)

    def leave(folder: Path, board: str, rom: CorrectionRom | None, layout: int = 0) -> Path:
        content, places = packed(board, layout)
        bitstream = read_bitstream(content)
        record = {"format": FORMAT, "version": VERSION, "board": board, "layout_sha256": places.sha256(bitstream)}
        record |= {"tables": places.to_json()}
        if rom is not None:
            content = bitstream.with_bits(place_tables(bitstream, places.in_file, rom_contents(rom)))
            record = with_rom(record, content, rom.crc32)
        path = folder / board / BUILT_BOARDS[board][2]
        path.parent.mkdir(parents=True)
        path.write_bytes(content)
        path.with_name("build.json").write_bytes(record_json(record))
        return path

    return leave


@pytest.fixture(params=list(BUILT_BOARDS))
def board(request) -> str:
    """A board of each family."""
    return request.param


@pytest.fixture
def built(board, tmp_path, rng, monkeypatch, leave_built) -> Path:
    """The bitstream of `board` under build/, in the current folder, with a ROM that is saved as old.rom.json.

    Another ROM is saved as new.rom.json.
    """
    monkeypatch.chdir(tmp_path)
    old = random_rom(rng, "OLD-1")
    save_rom(old, "old.rom.json")
    save_rom(random_rom(rng, "NEW-2"), "new.rom.json")
    return leave_built(tmp_path / "build", board, old)


@pytest.fixture
def arcref():
    """Runs the command: `arcref("patch", ...)` gives click's result."""

    def run(*arguments):
        return CliRunner().invoke(main, [str(argument) for argument in arguments])

    return run
