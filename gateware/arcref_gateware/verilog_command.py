"""`arcref verilog`: the core as one Verilog file, with its correction inside."""

import json
from pathlib import Path

import click

from arcref.atomic_file import write_files
from arcref.input_error import InputError
from arcref.rom_image import load_rom
from arcref_gateware.connected_encoder import ConnectedEncoder
from arcref_gateware.latency import LATENCY_CLOCKS
from arcref_gateware.quadrature import SAMPLES_PER_WORD
from arcref_gateware.strobe_delay import STROBE_DELAY_BITS
from arcref_gateware.verilog_export import describe_core, export_verilog

FILE = click.Path(path_type=Path)


@click.command()
@click.option(
    "--samples",
    type=click.Choice([str(samples) for samples in SAMPLES_PER_WORD]),
    default="4",
    show_default=True,
    help="Samples a word: 1 plain, 2 with DDR inputs, 4 with ECP5 gearing.",
)
@click.option("--rom", "rom_path", type=FILE, required=True, metavar="X.rom.json", help="ROM image of the correction.")
@click.option("-o", "--output", type=FILE, required=True, metavar="CORE.v", help="Verilog file to write.")
@click.option(
    "--strobe-delay",
    type=click.IntRange(0, (1 << STROBE_DELAY_BITS) - 1),
    default=0,
    show_default=True,
    metavar="SAMPLES",
    help="Reset value of the strobe delay, in sample periods.",
)
@click.option(
    "--gate",
    type=click.Choice(["00", "10", "11", "01"]),
    default="11",
    show_default=True,
    help="State of A and B in which a high Z is the zero mark.",
)
def verilog(samples, rom_path, output, strobe_delay, gate):
    """Write the core as Verilog.

    Module arcref_core, and beside it a JSON file of the same name with its ports and its latency.
    """
    description = output.with_suffix(".json")
    if output.suffix != ".v":
        raise InputError(f"{output}: the name of a Verilog file must end in .v")
    if description.resolve() == rom_path.resolve():
        raise InputError(f"{output}: its description {description} would replace the ROM image; choose another name")
    core = ConnectedEncoder(
        load_rom(rom_path),
        int(samples),
        gate_state=(int(gate[0]), int(gate[1])),
        strobe_delay=strobe_delay,
    )
    text = export_verilog(core)
    write_files({output: text.encode(), description: (json.dumps(describe_core(core), indent=2) + "\n").encode()})
    click.echo(f"{output}: module arcref_core, {samples} samples a word, latency {LATENCY_CLOCKS} clocks")
    click.echo(f"{description}: its ports and parameters")
