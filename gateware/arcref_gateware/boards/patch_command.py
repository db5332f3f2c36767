"""`arcref patch`: another ROM into a built bitstream, in seconds and without place and route."""

from pathlib import Path

import click

from arcref.atomic_file import write_files
from arcref.input_error import InputError
from arcref.rom_identity import decode_identity
from arcref.rom_image import load_rom
from arcref_gateware.boards.bitstream_tables import TablesDiffer, replace_tables
from arcref_gateware.boards.build_record import (
    DEFAULT_BUILD_FOLDER,
    bitstream_of_board,
    read_built,
    record_json,
    record_path,
    with_rom,
)
from arcref_gateware.boards.table_layout import TablesNotFound
from arcref_gateware.table_contents import rom_contents
from arcref_gateware.toolchain import ToolError

FILE = click.Path(path_type=Path)


@click.command()
@click.argument("bitstream", type=FILE, required=False)
@click.option("--board", metavar="BOARD", help="Patch the bitstream that `arcref build` left for this board.")
@click.option("--rom", "rom_path", type=FILE, required=True, metavar="X.rom.json", help="ROM image to put in.")
@click.option("-o", "--output", type=FILE, metavar="FILE", help="Write here.  [default: the bitstream itself]")
@click.option(
    "--build-folder",
    type=FILE,
    default=DEFAULT_BUILD_FOLDER,
    show_default=True,
    metavar="FOLDER",
    help="Where bitstreams are built.",
)
def patch(bitstream, board, rom_path, output, build_folder):
    """Put another ROM into a built bitstream, in seconds.

    The result is unpacked, and every word of all three tables is compared with the image before the file takes its
    name. The build record goes with it.
    """
    rom = load_rom(rom_path)
    if board is not None and board.endswith(".toml"):
        board = Path(board).stem  # the name that `arcref build` gives a board of one's own
    if bitstream is None:
        if board is None:
            raise InputError("name the bitstream, or the board with --board")
        bitstream = bitstream_of_board(board, build_folder)
    built = read_built(bitstream)
    if board is not None and built.board != board:
        raise InputError.at(bitstream, f"was built for the board {built.board!r}, not for {board!r}")
    output = output or bitstream
    if output.suffix != bitstream.suffix:
        raise InputError(f"{output}: the name must end in {bitstream.suffix}, as that of {bitstream} does")
    if rom_path.resolve() in (output.resolve(), record_path(output).resolve()):
        raise InputError(f"{rom_path}: the result would replace the ROM image")
    contents = rom_contents(rom)
    try:
        content = replace_tables(built.bitstream, built.layout, contents)
    except TablesNotFound as error:
        raise InputError.at(rom_path, f"does not fit into {bitstream}: {error}") from error
    except (TablesDiffer, ToolError) as error:
        click.echo(f"arcref: {bitstream} is left as it was: {error}", err=True)
        raise click.exceptions.Exit(1) from error
    record = with_rom(built.record, content, rom.crc32)
    write_files({output: content, record_path(output): record_json(record)})
    before = "the placeholder" if built.rom_crc32 is None else f"0x{built.rom_crc32:08X}"
    words = sum(len(table) for table in contents)
    click.echo(f"{output}: ROM 0x{rom.crc32:08X} in place of {before}, all {words} words unpacked and compared")
    identity = decode_identity(contents.identity).values
    click.echo(f"calibration: serial {identity['serial']}, date {identity['date']}")
