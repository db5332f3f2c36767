"""`arcref flash` calls openFPGALoader rightly, believes it only when it tells of no failure, and says what to do."""

import stat
import sys
from pathlib import Path

import pytest

from arcref_gateware.boards.open_fpga_loader import LoaderCommand, explain, failed

CONSTRAINTS = Path(__file__).parents[3] / "constraints"


@pytest.fixture
def loader(tmp_path, monkeypatch):
    """A stand-in for openFPGALoader: writes down how it was called, prints `output.txt`, ends with `status.txt`."""
    folder = tmp_path / "loader"
    folder.mkdir()
    script = folder / "openFPGALoader"
    script.write_text(
        f"#!{sys.executable}\n"
        "import sys\n"
        "from pathlib import Path\n"
        f"folder = Path({str(folder)!r})\n"
        "with open(folder / 'calls.txt', 'a') as calls:\n"
        "    print(*sys.argv[1:], sep='\\t', file=calls)\n"
        "output, status = folder / 'output.txt', folder / 'status.txt'\n"
        "print(output.read_text() if output.exists() else 'write to flash\\nDONE')\n"
        "sys.exit(int(status.read_text()) if status.exists() else 0)\n"
    )
    script.chmod(script.stat().st_mode | stat.S_IXUSR)
    monkeypatch.setenv("OPENFPGALOADER", str(script))
    return folder


def calls(loader) -> list[list[str]]:
    path = loader / "calls.txt"
    return [line.split("\t") for line in path.read_text().splitlines()] if path.exists() else []


NAMED = {"hx8k": "ice40_generic", "ulx3s-12F": "ulx3s"}


def flash(arcref, *arguments):
    return arcref("flash", "--constraints", CONSTRAINTS, *arguments)


def test_the_flash_is_written_and_verified(built, board, arcref, loader):
    result = flash(arcref, "--board", board, "--rom", "old.rom.json")
    assert result.exit_code == 0, result.output
    path = str(Path("build", board, built.name))
    assert calls(loader) == [["--board", NAMED[board], "--write-flash", "--verify", path]]
    assert "written and verified" in result.stdout


def test_the_fpga_alone_is_loaded(built, board, arcref, loader):
    result = flash(arcref, "--board", board, "--sram")
    assert result.exit_code == 0, result.output
    assert calls(loader) == [["--board", NAMED[board], "--write-sram", str(Path("build", board, built.name))]]
    assert "until power-off" in result.stdout


def test_another_cable_and_another_file(built, board, arcref, loader):
    result = flash(arcref, built, "--board", board, "--cable", "dirtyJtag")
    assert result.exit_code == 0, result.output
    expected = ["--board", NAMED[board], "--cable", "dirtyJtag", "--write-flash", "--verify", str(built)]
    assert calls(loader) == [expected]


def test_a_dry_run_prints_the_command_and_calls_nothing(built, board, arcref, loader):
    result = flash(arcref, "--board", board, "--rom", "old.rom.json", "--dry-run")
    assert result.exit_code == 0, result.output
    assert f"--board {NAMED[board]} --write-flash --verify build/{board}/{built.name}" in result.stdout
    assert calls(loader) == []


def refused(result, loader, complaint):
    assert result.exit_code == 2, result.output
    assert result.stderr.count("\n") == 1
    assert complaint in result.stderr
    assert calls(loader) == []


def test_a_bitstream_with_another_rom_is_refused(built, board, arcref, loader):
    refused(flash(arcref, "--board", board, "--rom", "new.rom.json"), loader, "was asked for; patch it first")
    refused(flash(arcref, "--board", board, "--rom", "new.rom.json", "--dry-run"), loader, "was asked for")


def test_a_bitstream_for_another_board_is_refused(built, board, arcref, loader):
    other = next(name for name in NAMED if name != board)
    refused(flash(arcref, built, "--board", other), loader, f"was built for the board {board!r}, not for {other!r}")


def test_a_record_that_claims_another_rom_is_not_believed(built, board, arcref, loader):
    # The bitstream itself says what it carries: swap it for one with the other ROM, behind the record's back.
    record = built.with_name("build.json").read_bytes()
    assert arcref("patch", "--board", board, "--rom", "new.rom.json").exit_code == 0
    built.with_name("build.json").write_bytes(record)
    refused(flash(arcref, "--board", board, "--rom", "old.rom.json"), loader, "its record says otherwise")


def test_a_bitstream_without_a_rom_is_refused(board, arcref, loader, tmp_path, leave_built):
    waiting = leave_built(tmp_path / "waiting", board, None)
    refused(flash(arcref, waiting, "--board", board), loader, "carries no ROM yet")


def test_bad_use_is_refused(built, board, arcref, loader):
    refused(flash(arcref, "--board", "ulx4s"), loader, "did you mean")
    refused(flash(arcref, "--board", "icebreaker"), loader, "run `arcref build --board icebreaker")
    built.write_bytes(b"not a bitstream")
    refused(flash(arcref, "--board", board), loader, "no bitstream")


@pytest.mark.parametrize(
    ("output", "status", "sentence"),
    [
        ("unable to open ftdi device: -3 (device not found)\nJTAG init failed with: unable to open", 1, "plug its"),
        ("Open device 1209:5af0 Not found\nDFU init failed with: No DFU compatible device found", 1, "plug its"),
        ("unable to open ftdi device: -4 (usb_open() failed)", 1, "udev rule"),
        ("unable to open ftdi device: -5 (unable to claim usb device)", 1, "close other programs"),
        ("found 0 devices\nError: no device found", 1, "switch the board on"),
        ("mismatch between target's idcode and bitstream idcode", 1, "build the right variant"),
        ("Jtag: support for cmsisdap was not enabled at compile time", 1, "--cable"),
        ("Error: cannot find board 'x'", 1, "correct [flash] board"),
        ("Writing: DONE\nVerifying write: Verify Failure", 0, "not what was written"),
        ("Wait for CDONE FAIL", 0, "did not start with it"),
        ("FAIL\nParse file DONE\nWait for CDONE ", 0, "did not start with it"),
        ("Loading FAIL", 0, "status 0): Loading FAIL"),
        ("something new", 7, "status 7): something new"),
        ("", 1, "nothing was printed"),
        (
            "openFPGALoader: error while loading shared libraries: libusb-1.0.so.0: cannot open shared object file",
            127,
            "needs libusb-1.0.so.0 of the system: install it (Debian, Ubuntu: sudo apt install libusb-1.0-0",
        ),
        ("error while loading shared libraries: libftdi1.so.2: cannot open", 127, "sudo apt install libftdi1-2"),
        ("dyld[1]: Library not loaded: /opt/homebrew/lib/libftdi1.2.dylib", 6, "brew install libftdi"),
        ("error while loading shared libraries: libstrange.so.9: cannot open", 127, "libstrange.so.9 of the system"),
    ],
)
def test_every_failure_gets_a_sentence(output, status, sentence, board, built, arcref, loader):
    (loader / "output.txt").write_text(output)
    (loader / "status.txt").write_text(str(status))
    result = flash(arcref, "--board", board)
    assert result.exit_code == 1, result.output
    said = result.stderr.splitlines()[-1]
    assert said.startswith("arcref: ")
    assert sentence in said


def test_success_is_not_taken_for_failure():
    told = "write to flash\nEnable configuration: DONE\nSRAM erase: DONE\nErasing: 100.00%\nDone\nVerifying: DONE"
    assert not failed(told)


def test_a_board_without_a_way_to_be_loaded_is_told(tmp_path):
    with pytest.raises(Exception, match=r"\[flash\] board or cable"):
        LoaderCommand(tmp_path / "x.bit", {}).arguments()
    assert explain("", 3, LoaderCommand(tmp_path / "x.bit", {"cable": "ft2232"})).endswith("nothing was printed")


def test_an_executable_that_does_not_run_is_told(built, board, arcref, monkeypatch, tmp_path):
    monkeypatch.setenv("OPENFPGALOADER", str(tmp_path / "nowhere"))
    result = flash(arcref, "--board", board)
    assert result.exit_code == 2
    assert "does not run: No such file" in result.stderr


def test_the_real_one_with_no_cable_says_what_is_missing(built, board, arcref, monkeypatch):
    monkeypatch.delenv("OPENFPGALOADER", raising=False)
    result = flash(arcref, "--board", board)
    assert result.exit_code == 1, result.output
    said = result.stderr.splitlines()[-1]
    # Which of the two depends on what this machine has installed.
    assert "of the system: install it" in said or "plug its programming port in" in said or "udev rule" in said
    assert "Traceback" not in result.output
