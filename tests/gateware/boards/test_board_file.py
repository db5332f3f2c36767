# amaranth: UnusedElaboratable=no
"""Board files: the shipped ones, and one clear line for each thing that can be wrong in one's own."""

import re
from pathlib import Path

import pytest

from arcref.input_error import InputError
from arcref.link.packet import DEFAULT_BAUD
from arcref_gateware.boards.board import SIGNAL_DIRECTIONS, UART_SIGNALS
from arcref_gateware.boards.board_file import board_names, load_board
from arcref_gateware.boards.board_platform import board_platform
from arcref_gateware.boards.board_top import BoardTop
from arcref_gateware.boards.pin_tables import package_balls
from arcref_gateware.boards.self_test import SelfTest
from arcref_gateware.toolchain import use_installed_yosys

CONSTRAINTS = Path(__file__).parents[3] / "constraints"
OWN_ICE40 = Path(__file__).parent / "encoder_board_ice40.toml"
ULX3S_VARIANTS = ["ulx3s", "ulx3s-45F", "ulx3s-25F", "ulx3s-12F"]
EVERY_BOARD = [*ULX3S_VARIANTS, "hx8k", "icebreaker", "ecpix5", "ecpix5-45", "encoder_board"]


@pytest.mark.parametrize("name", EVERY_BOARD)
def test_every_shipped_board_is_read(name):
    board = load_board(name, CONSTRAINTS)
    assert board.name == name
    assert board.has_link == (name != "icebreaker")  # which is too small for it
    left_out = set() if board.has_link else {*UART_SIGNALS, "compare"}
    assert set(board.pins) == set(SIGNAL_DIRECTIONS) - left_out
    assert board.baud == DEFAULT_BAUD
    balls = [ball for pin in board.pins.values() for ball in pin.balls]
    assert len(balls) == len(set(balls))
    assert set(balls) <= set(package_balls(board.device, board.package))
    assert board.flash


def test_every_file_in_constraints_is_tested():
    assert {name.partition("-")[0] for name in EVERY_BOARD} == set(board_names(CONSTRAINTS))


def test_the_three_boards_that_must_reach_their_clock_ask_for_it():
    for name, part, samples, least_hz in (
        ("ulx3s", "LFE5U-85F", 4, 160e6),
        ("hx8k", "iCE40HX8K", 2, 168e6),
        ("icebreaker", "iCE40UP5K", 2, 84e6),
    ):
        board = load_board(name, CONSTRAINTS)
        assert (board.device, board.samples_per_word) == (part, samples)
        assert board.word_clock_hz >= least_hz
        assert board.samples_per_s == samples * board.word_clock_hz


@pytest.mark.parametrize("name", ["ulx3s", "hx8k", "icebreaker", "ecpix5", "encoder_board", OWN_ICE40])
def test_every_board_elaborates_with_its_balls_standards_and_clocks(name, random_rom):
    use_installed_yosys()
    board = load_board(name, CONSTRAINTS)
    platform = board_platform(board)
    plan = platform.build(BoardTop(board, random_rom), name="top", do_build=False)
    text = _text(plan.files["top.lpf" if board.family == "ecp5" else "top.pcf"])
    for pin in board.pins.values():
        assert re.search(rf"arcref_{pin.signal}_0__\w+\"? (SITE )?\"?{pin.balls[0]}\b", text), pin
        if board.family == "ecp5":
            attributes = re.search(rf"IOBUF PORT \"arcref_{pin.signal}_0__\w+\" (.*);", text)[1].split()
            assert f"IO_TYPE={pin.io_standard}" in attributes
            assert f"PULLMODE={pin.pull.upper()}" in attributes
            assert ("DIFFRESISTOR=100" in attributes) == (pin.termination_ohm == 100)
    clocks = {"word_clock": board.word_clock_hz, "oscillator_clock": board.oscillator_hz}
    if board.samples_per_word == 4:
        clocks |= {"edge_clock": 2 * board.word_clock_hz, "pll_clock": 2 * board.word_clock_hz}
    for clock, frequency_hz in clocks.items():
        unit = 1 if board.family == "ecp5" else 1e6
        line = next(line for line in text.splitlines() if f".{clock}" in line)
        assert float(re.findall(r"[\d.]+(?:e[+-]?\d+)?", line)[-1]) == pytest.approx(frequency_hz / unit)


@pytest.mark.parametrize("name", ["ulx3s", "hx8k", "icebreaker"])
def test_every_kind_of_board_elaborates_with_its_self_test(name, random_rom):
    use_installed_yosys()
    board = load_board(name, CONSTRAINTS)
    top = BoardTop(board, random_rom, self_test=SelfTest())
    netlist = _text(board_platform(board).build(top, name="top", do_build=False).files["top.il"])
    assert "generator" in netlist
    assert ("course" in netlist) != board.has_link, "with a link the host turns it"


def _text(content) -> str:
    return content if isinstance(content, str) else content.decode()


ECP5_BOARD = (CONSTRAINTS / "encoder_board.toml").read_text(encoding="utf-8")
ICE40_BOARD = OWN_ICE40.read_text(encoding="utf-8")
ULX3S = (CONSTRAINTS / "ulx3s.toml").read_text(encoding="utf-8")


def refusal(text: str, old: str, new: str, tmp_path) -> str:
    """The line with which a board file is refused in which `old` is replaced."""
    assert old in text
    path = tmp_path / "board.toml"
    path.write_text(text.replace(old, new), encoding="utf-8")
    with pytest.raises(InputError) as error:
        load_board(path)
    line = str(error.value)
    assert line.startswith(str(path))
    assert "\n" not in line
    return line.removeprefix(str(path))


@pytest.mark.parametrize(
    ("text", "old", "new", "says"),
    [
        # Pins.
        (ULX3S, '"gpio_0:15+"', '"gpio_0:14+"', "b is on 'gpio_0:14+' (ball U18), which a has already"),
        (ULX3S, '"gpio_0:15+"', '"U18"', "b is on 'U18' (ball U18), which a has already"),
        (ULX3S, '"gpio_0:15+"', '"G2"', "b is on 'G2' (ball G2), which the oscillator has already"),
        (ULX3S, '"gpio_0:15+"', '"gpio_0:28+"', "b is on 'gpio_0:28+', which the board lacks; did you mean gpio_0:"),
        (ULX3S, '"gpio_0:15+"', '"Z99"', "b is on 'Z99', which the package BG381 of LFE5U-85F lacks"),
        (
            ULX3S,
            '"gpio_0:15+"',
            '"gpio_0:27+"',
            "b is on 'gpio_0:27+', in bank 1: four samples a word need bank 2 or 3",
        ),
        (
            ULX3S,
            '"gpio_0:15+"',
            '"gpio_0:12+"',
            "a and b are on different sides: all sampled lines must share one edge",
        ),
        (ULX3S, '"gpio_0:17-"', '"gpio_0:0+"', "alignment is on 'gpio_0:0+', in bank 0"),
        (ULX3S, "strobe =", "strobo =", "strobo is no signal of the instrument; did you mean 'strobe'?"),
        (ULX3S, "spi_cs_n = {", "#", "spi_cs_n missing"),
        (ULX3S, "alignment = {", "#", "alignment missing (a ball with nothing wired to it"),
        (ULX3S, 'label = "GP15"', 'lable = "GP15"', "b.lable is not known; did you mean label?"),
        (ULX3S, 'pin = "gpio_0:15+",', "", "b needs either pin (one ball) or pair"),
        (ULX3S, 'pin = "gpio_0:15+"', "pin = 15", "names of pins in quotation marks were expected"),
        (
            ULX3S,
            '15+", io_standard = "LVCMOS33"',
            '15+", io_standard = "LVCMOS34"',
            "b.io_standard is 'LVCMOS34', one of LVCMOS12",
        ),
        (
            ULX3S,
            'LVCMOS33", pull = "up", label = "GP15"',
            'LVCMOS33", pull = "high"',
            "b.pull is 'high', one of none, up, down",
        ),
        (
            ICE40_BOARD,
            '"113", io_standard = "SB_LVCMOS", pull = "up"',
            '"113", io_standard = "SB_LVCMOS", pull = "down"',
            "strobe.pull is 'down', one of none, up was expected for ice40",
        ),
        # Pairs.
        (ECP5_BOARD, '["L16", "L15"]', '["L16", "M15"]', "a: L16 and M15 are no pair; the other ball of L16 is L15"),
        (ECP5_BOARD, '["L16", "L15"]', '["L15", "L16"]', "a: L15 and L16 are no pair; L15 can be no positive one"),
        (ECP5_BOARD, '["L16", "L15"]', '["L16"]', "a.pair has 1 names, two were expected"),
        (ECP5_BOARD, '["L16", "L15"]', '["L16", "L16"]', "a: L16 and L16 are no pair"),
        (
            ECP5_BOARD,
            '["M16", "M15"], io_standard = "LVDS"',
            '["M16", "M15"], io_standard = "LVCMOS33"',
            "expected for a pair",
        ),
        (ECP5_BOARD, 'termination_ohm = 100, label = "J1 B+', 'termination_ohm = 120, label = "J1 B+', "it is 100"),
        (
            ECP5_BOARD,
            'led_fault = { pin = "M2", io_standard = "LVCMOS33"',
            'led_fault = { pair = ["K13", "K12"], io_standard = "LVDS"',
            "led_fault is an output; a pair is for inputs only",
        ),
        (ICE40_BOARD, '["8", "7"]', '["7", "8"]', "a: 7 and 8 are no pair; 7 can be no positive one"),
        (ICE40_BOARD, '["8", "7"]', '["112", "110"]', "a is a pair outside of bank 3"),
        # Part, clock, samples.
        (
            ECP5_BOARD,
            '"LFE5U-25F"',
            '"LFE5U-26F"',
            "column fpga: the tools know no part 'LFE5U-26F'; they know LFE5U-12F",
        ),
        (ECP5_BOARD, '"BG256"', '"BG257"', "LFE5U-25F has no package 'BG257'; it has BG256"),
        (ECP5_BOARD, 'family = "ecp5"', 'family = "ice40"', "'LFE5U-25F' is no part of the family ice40"),
        (
            ECP5_BOARD,
            'family = "ecp5"',
            'family = "artix"',
            "the family 'artix' is not known; the families are ecp5, ice40",
        ),
        (ECP5_BOARD, 'speed = "6"', 'speed = "5"', "the speed grade of an ECP5 is 6, 7 or 8, not '5'"),
        (
            ECP5_BOARD,
            'oscillator_pin = "K1"',
            'oscillator_pin = "K99"',
            "clock.oscillator_pin: is 'K99', which the package BG256 lacks",
        ),
        (
            ECP5_BOARD,
            "oscillator_hz = 25_000_000",
            'oscillator_hz = "25 MHz"',
            "is '25 MHz', a frequency in hertz was expected",
        ),
        (
            ECP5_BOARD,
            "word_clock_hz = 162_500_000",
            "word_clock_hz = 160_000_000",
            "column clock.word_clock_hz: 320 MHz cannot be had from 25 MHz; the nearest that can: 312.5 and 325 MHz",
        ),
        (
            ECP5_BOARD,
            "word_clock_hz = 162_500_000",
            "word_clock_hz = 250_000_000",
            "the ECP5's PLL gives 3.125 .. 400 MHz, not 500 MHz",
        ),
        (
            ECP5_BOARD,
            "word_clock_hz = 162_500_000",
            "",
            "clock.word_clock_hz: is missing, a frequency in hertz was expected",
        ),
        (
            ICE40_BOARD,
            "word_clock_hz = 112_000_000",
            "word_clock_hz = 113_000_000",
            "113 MHz cannot be had from 16 MHz",
        ),
        (ICE40_BOARD, "per_word = 2", "per_word = 4", "samples.per_word: is 4, one of 1, 2 was expected for ice40"),
        # Serial link.
        (
            ECP5_BOARD,
            "baud = 3_000_000",
            "baud = 25_000_000",
            "link.baud: 2.5e+07 baud needs a clock of 200 MHz",
        ),
        (
            ECP5_BOARD,
            "baud = 3_000_000",
            "baud = 17_000_000",
            "link.baud: 1.7e+07 baud would be -4.4 % off at a clock of 162.5 MHz; 2 % is the most",
        ),
        (ECP5_BOARD, "baud = 3_000_000", 'baud = "fast"', "link.baud: is 'fast', a baud rate was expected"),
        (ECP5_BOARD, "uart_tx = {", "#", "uart_tx missing: uart_rx is there, and the serial link needs both"),
        (
            ICE40_BOARD,
            "led_fault =",
            'compare = { pin = "120", io_standard = "SB_LVCMOS" }\nled_fault =',
            "compare needs the serial link, by which it is set: wire uart_rx and uart_tx, too",
        ),
        (
            ICE40_BOARD,
            "[flash]",
            "[link]\nbaud = 3_000_000\n[flash]",
            "column link: has no meaning without the pins uart_rx and uart_tx",
        ),
        (ECP5_BOARD, "per_word = 4", "per_word = true", "is True, a whole number was expected"),
        (
            ULX3S,
            "word_clock_hz",
            "oscillator_hz = 25_000_000\nword_clock_hz",
            "is stated by amaranth-boards already; leave it out",
        ),
        # Tables and keys.
        (
            ECP5_BOARD,
            "word_clock_hz",
            "word_clok_hz",
            "clock.word_clok_hz: is not known; did you mean 'word_clock_hz'?",
        ),
        (ECP5_BOARD, "[samples]", "[sample]", "column sample: is not known; did you mean 'samples'?"),
        (ULX3S, "ULX3S_{variant}_Platform", "ULX4S_{variant}_Platform", "is no platform of amaranth-boards"),
        (
            ULX3S,
            "amaranth_boards.ulx3s:ULX3S_{variant}_Platform",
            "amaranth_boards.arty_a7:ArtyA7_{variant}Platform",
            "is no platform",
        ),
        (ULX3S, '"85F", "45F"', '"86F", "45F"', "'amaranth_boards.ulx3s:ULX3S_86F_Platform' is no platform"),
        (ULX3S, "{variant}", "85F", "board.variants: and '{variant}' in board.amaranth_platform go together"),
        (ECP5_BOARD, "seeds = [1,", "seeds = [0,", "a list of whole numbers from 1 was expected"),
        (ECP5_BOARD, '["-abc9"]', "[9]", "build.synthesis_options: is [9], a list of strings was expected"),
        (ECP5_BOARD, "[board]", "[board", "is not TOML"),
    ],
)
def test_what_is_wrong_is_told_in_one_line(text, old, new, says, tmp_path):
    line = refusal(text, old, new, tmp_path)
    assert says in line


def test_a_part_that_the_file_states_beside_its_platform_must_be_the_one_that_the_board_carries(tmp_path):
    path = tmp_path / "board.toml"
    path.write_text(ULX3S + '\n[fpga]\nspeed = "8"\n', encoding="utf-8")
    with pytest.raises(
        InputError, match="fpga.speed: is '8', but amaranth_boards.ulx3s:ULX3S_85F_Platform carries '6'"
    ):
        load_board(path)


def test_a_table_that_is_none_is_told(tmp_path):
    path = tmp_path / "board.toml"
    path.write_text("flash = 3\n" + ULX3S.replace('[flash]\nboard = "ulx3s"', ""), encoding="utf-8")
    with pytest.raises(InputError, match=r"column flash: is 3, a table \[flash\] was expected"):
        load_board(path)


def test_an_unknown_board_names_the_known_ones():
    with pytest.raises(InputError, match=r"no board 'icebraker' \(.*hx8k.*\); did you mean 'icebreaker'\?"):
        load_board("icebraker", CONSTRAINTS)
    with pytest.raises(InputError, match="has no '13F', one of 85F, 45F, 25F, 12F was expected"):
        load_board("ulx3s-13F", CONSTRAINTS)
    with pytest.raises(InputError, match="there is no such file"):
        load_board("nowhere/my_board.toml", CONSTRAINTS)


def test_one_sample_a_word_needs_no_alignment_ball(tmp_path):
    path = tmp_path / "board.toml"
    text = re.sub(r"alignment = .*", "", ICE40_BOARD.replace("per_word = 2", "per_word = 1"))
    path.write_text(text, encoding="utf-8")
    board = load_board(path)
    assert "alignment" not in board.pins
