"""`arcref twin`: the whole instrument in simulation, on a serial port that other programs open."""

import queue
import signal
import sys
import threading
import time
from pathlib import Path

import click

from arcref.angle import COUNTS_PER_LINE
from arcref.correction_rom import FRACTION_BITS, CorrectionRom
from arcref.input_error import InputError
from arcref.instrument_error import InstrumentError
from arcref.link.packet import DEFAULT_BAUD
from arcref.rom_command import read_curve
from arcref.rom_image import load_rom
from arcref.rom_provenance import fit_from_provenance
from arcref_gateware.connected_encoder import DEFAULT_WORD_CLOCK_HZ
from arcref_gateware.link.baud_rate import baud_divisor
from arcref_sim.core_options import build_folder_option, samples_option
from arcref_sim.graduation import GraduationError
from arcref_sim.square_waves import SquareWaves
from arcref_sim.twin.noisy_wire import noisy_wire
from arcref_sim.twin.twin import Twin
from arcref_sim.twin.twin_prompt import FASTEST_RPS, Quit, describe_slowdown, obey

FILE = click.Path(path_type=Path)
DEFAULT_ROM = Path("build/arcref.rom.json")
DEFAULT_LINK = Path("build/twin")
LONGEST_DELAY_NS = 1e6


@click.command()
@click.option("--rom", "rom_path", type=FILE, default=DEFAULT_ROM, show_default=True, metavar="X.rom.json")
@click.option(
    "--curve",
    type=FILE,
    metavar="CAL.json|POLYGON.csv",
    help="The encoder's true error: its fit.  [default: what the ROM corrects]",
)
@click.option("--speed", type=float, default=0.0, show_default=True, metavar="RPS", help="Turns a second, - reverse.")
@click.option("--strobe", "strobe_hz", type=float, default=0.0, metavar="HZ", help="Strobes a second on the pin.")
@click.option("--random-strobes", is_flag=True, help="Strobe at random distances.")
@click.option("--jitter", "jitter_ns", type=float, default=0.0, metavar="NS", help="Of each edge, standard deviation.")
@click.option("--delay", "delay_ns", type=float, default=0.0, metavar="NS", help="Of A, B and Z: the interpolator's.")
@click.option("--fault", "faults", multiple=True, metavar="NAME[=N]", help="A fault once it turns; see `fault`.")
@click.option(
    "--noise", "noise", type=float, default=0.0, metavar="PART", help="Of the wire's bytes, spoilt either way."
)
@click.option("--seed", type=click.IntRange(min=0), default=0, show_default=True, help="Of jitter, strobes and noise.")
@samples_option
@click.option("--baud", type=click.IntRange(min=1), default=DEFAULT_BAUD, show_default=True, help="Of the UART's pins.")
@click.option("--generator", is_flag=True, help="With the on-board test generator: `arcref zero-return --generator`.")
@click.option("--link", type=FILE, default=DEFAULT_LINK, show_default=True, help="Symbolic link made to the port.")
@click.option("--seconds", type=float, metavar="S", help="End by itself after so long.")
@click.option("--realtime", is_flag=True, help="Never run faster than real time.")
@click.option("--sleep", "sleep_s", type=float, metavar="S", help="Stand still when the port was silent so long.")
@build_folder_option
def twin(
    rom_path, curve, speed, strobe_hz, random_strobes, jitter_ns, delay_ns, faults, noise, seed, samples, baud,
    generator, link, seconds, realtime, sleep_s, build_folder,
):  # fmt: skip
    """Run the instrument in simulation, on a serial port.

    The gateware as it is flashed, compiled with Verilator, with its UART on a pseudo-terminal and a synthetic encoder
    on its inputs. Every other command works on it: `arcref info --port build/twin`. Lines typed here change speed,
    strobes and faults; `help` lists them. Ends on `quit`, Ctrl-C or after --seconds.
    """
    _check(speed, jitter_ns, delay_ns, noise, baud, seconds, sleep_s)
    if rom_path == DEFAULT_ROM and not rom_path.exists():
        raise InputError(f"{rom_path}: there is no ROM yet; `make rom` makes it, or name one with --rom")
    rom = load_rom(rom_path)
    if curve:
        graduation = GraduationError.from_curve(fit_from_provenance(read_curve(curve), rom.provenance).evaluate)
    else:
        graduation = error_that_the_rom_corrects(rom)
    lines = [f"fault {fault.replace('=', ' ')}" for fault in faults]
    if strobe_hz:
        lines.insert(0, f"strobe {strobe_hz!r}{' random' if random_strobes else ''}")
    click.echo("compiling the instrument, a minute unless that was done before", err=True)
    instrument = Twin(
        rom,
        samples_per_word=int(samples),
        baud=baud,
        has_test_generator=generator,
        speed_rps=speed,
        graduation=graduation,
        waves=SquareWaves(jitter_ns=jitter_ns, delay_ns=delay_ns),
        seed=seed,
        realtime=realtime,
        sleep_after_s=sleep_s,
        change_bytes=noisy_wire(seed, noise) if noise else bytes,
        link=link,
        folder=build_folder,
    )
    # Taken as Ctrl-C is, so that its port and link are taken away, too.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    with instrument:
        click.echo(f"port: {instrument.port}")
        click.echo(f"link: {link}")
        try:
            for line in lines:
                click.echo(obey(instrument, line))
        except ValueError as error:
            raise InputError(str(error)) from None
        _serve(instrument, seconds)
        slowdown = describe_slowdown(instrument.status())
    click.echo(f"ended, {slowdown}")


def error_that_the_rom_corrects(rom: CorrectionRom) -> GraduationError:
    """The error of an encoder that this ROM corrects: its line table, straight from the middle of a line to the next.
    What the ROM says within the lines is left out.
    """
    middles = rom.line_table / (1 << FRACTION_BITS)
    between = (middles + [*middles[-1:], *middles[:-1]]) / 2
    assert COUNTS_PER_LINE % 2 == 0
    return GraduationError([value for pair in zip(between, middles, strict=True) for value in pair])


def _check(speed, jitter_ns, delay_ns, noise, baud, seconds, sleep_s) -> None:
    """Raises `InputError` for an option out of range."""
    for name, value, least, most in (
        ("--speed", speed, -FASTEST_RPS, FASTEST_RPS),
        ("--jitter", jitter_ns, 0, 1000),
        ("--delay", delay_ns, 0, LONGEST_DELAY_NS),
        ("--noise", noise, 0, 1),
        ("--seconds", seconds, 0, 1e9),
        ("--sleep", sleep_s, 0, 1e9),
    ):
        if value is not None and not least <= value <= most:
            raise InputError(f"{name} is {value:g}, it must lie in {least:g} .. {most:g}")
    try:
        baud_divisor(DEFAULT_WORD_CLOCK_HZ, baud)
    except ValueError as error:
        raise InputError(f"--baud: {error}") from None


def _serve(instrument: Twin, seconds: float | None) -> None:
    """Obey the lines that are typed until the end."""
    typed: queue.SimpleQueue[str | None] = queue.SimpleQueue()
    threading.Thread(target=_read_lines, args=(typed,), daemon=True).start()
    ends_s = None if seconds is None else time.monotonic() + seconds
    told_at_s = time.monotonic() + 2.0
    while instrument.running:
        now = time.monotonic()
        if ends_s is not None and now >= ends_s:
            return
        if told_at_s is not None and now >= told_at_s:
            click.echo(describe_slowdown(instrument.status()))
            told_at_s = None
        try:
            line = typed.get(timeout=min(0.2, max(ends_s - now, 0.0)) if ends_s is not None else 0.2)
        except queue.Empty:
            continue
        try:
            if answer := obey(instrument, line):
                click.echo(answer)
        except ValueError as error:
            click.echo(str(error), err=True)
        except Quit:
            return
    raise InstrumentError("the twin has ended by itself")


def _read_lines(typed: queue.SimpleQueue) -> None:
    for line in sys.stdin:
        typed.put(line)
