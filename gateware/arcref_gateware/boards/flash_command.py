"""`arcref flash`: a built bitstream into a board, with openFPGALoader."""

import shlex
from pathlib import Path

import click

from arcref.input_error import InputError
from arcref.rom_image import load_rom
from arcref_gateware.boards.board_file import BOARD_FOLDER, load_board
from arcref_gateware.boards.build_record import DEFAULT_BUILD_FOLDER, BuiltBitstream, bitstream_of_board, read_built
from arcref_gateware.boards.open_fpga_loader import LoaderCommand, LoaderFailed, load, loader_executable

FILE = click.Path(path_type=Path)


@click.command()
@click.argument("bitstream", type=FILE, required=False)
@click.option("--board", "board_name", required=True, metavar="BOARD", help="The board that is plugged in.")
@click.option("--rom", "rom_path", type=FILE, metavar="X.rom.json", help="Refuse a bitstream with another ROM.")
@click.option("--sram", is_flag=True, help="Load the FPGA itself, until power-off, in place of its flash.")
@click.option("--cable", metavar="CABLE", help="Cable as openFPGALoader names it, in place of the board's own.")
@click.option("--dry-run", is_flag=True, help="Check everything, print the command and do not run it.")
@click.option(
    "--constraints",
    type=FILE,
    default=BOARD_FOLDER,
    show_default=True,
    metavar="FOLDER",
    help="Where the boards' files are.",
)
@click.option(
    "--build-folder",
    type=FILE,
    default=DEFAULT_BUILD_FOLDER,
    show_default=True,
    metavar="FOLDER",
    help="Where bitstreams are built.",
)
def flash(bitstream, board_name, rom_path, sram, cable, dry_run, constraints, build_folder):
    """Write a built bitstream into a board and verify it.

    Board and ROM are read out of the bitstream itself; it is refused when they are not the ones asked for. Ends with
    status 1 when the board was not loaded.
    """
    board = load_board(board_name, constraints)
    built = read_built(bitstream or bitstream_of_board(board.name, build_folder))
    crc32 = checked_rom(built, board.name, load_rom(rom_path).crc32 if rom_path else None)
    command = LoaderCommand(built.path, board.flash, to_sram=sram, cable=cable)
    line = shlex.join([loader_executable(), *command.arguments()])
    target = "the FPGA, until power-off" if sram else "the flash"
    click.echo(f"{built.path}: board {board.name}, ROM 0x{crc32:08X}, into {target}")
    if dry_run:
        click.echo(line)
        return
    try:
        load(command)
    except LoaderFailed as error:
        click.echo(f"arcref: {error}", err=True)
        raise click.exceptions.Exit(1) from error
    click.echo("loaded" if sram else "written and verified")


def checked_rom(built: BuiltBitstream, board: str, wanted_crc32: int | None) -> int:
    """The CRC-32 of the ROM in a bitstream. Raises `InputError` when board or ROM are not the ones asked for."""
    if built.board != board:
        raise InputError.at(built.path, f"was built for the board {built.board!r}, not for {board!r}")
    if built.rom_crc32 is None:
        raise InputError.at(built.path, "carries no ROM yet; put one in with `arcref patch`")
    if built.record.get("rom_crc32") != built.rom_crc32:
        problem = f"carries the ROM 0x{built.rom_crc32:08X}, its record says otherwise; patch or build it again"
        raise InputError.at(built.path, problem)
    if wanted_crc32 is not None and built.rom_crc32 != wanted_crc32:
        problem = f"carries the ROM 0x{built.rom_crc32:08X}, 0x{wanted_crc32:08X} was asked for; patch it first"
        raise InputError.at(built.path, problem)
    return built.rom_crc32
