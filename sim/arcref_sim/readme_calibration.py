"""The chapter "Calibrate" of README.md: its commands are run, and what they print and plot is put into the page.

Run as a module to write page and picture anew; a test fails when they and the commands differ.
"""

import os
import re
import shlex
import sys
import tempfile
from contextlib import chdir
from pathlib import Path

from click.testing import CliRunner

from arcref.atomic_file import write_files
from arcref.command import main
from arcref.manual_tables import fill_outputs

CHAPTER = "## Calibrate"
REPORT = "build/polygon.html"
PICTURE = Path("docs/images/calibrate_polygon.svg")
PICTURE_WIDTH = 740

_OUTPUT_COLUMNS = 80


def chapter_commands(readme: str) -> list[list[str]]:
    """The words of each command in the chapter's first block, `arcref` left out."""
    chapter = readme[readme.index(f"\n{CHAPTER}\n") :]
    block = re.search(r"\n\n((?:    arcref .*\n)+)", chapter)[1]
    return [shlex.split(line)[1:] for line in block.splitlines()]


def run_commands(commands: list[list[str]]) -> tuple[dict[str, str], str]:
    """Run the commands in a folder of their own; gives what each printed, by `verb-kind`, and the report's page.

    Raises `RuntimeError` when one does not end with status 0.
    """
    printed = {}
    with tempfile.TemporaryDirectory() as folder, chdir(folder):
        os.mkdir("build")
        for words in commands:
            result = CliRunner(env={"COLUMNS": str(_OUTPUT_COLUMNS), "FORCE_COLOR": None}).invoke(main, words)
            if result.exit_code:
                raise RuntimeError(f"arcref {shlex.join(words)} ended with {result.exit_code}: {result.output}")
            printed["-".join(words[:2])] = result.stdout
        return printed, Path(REPORT).read_text(encoding="utf-8")


def error_picture(page: str) -> str:
    """The report's plot of the error as a file of its own: coordinates to a tenth, short ids, a width."""
    svg = re.search(r"<svg.*?</svg>", page, re.DOTALL)[0]
    for number, name in enumerate(dict.fromkeys(re.findall(r' id="([^"]+)"', svg))):
        svg = svg.replace(f'"{name}"', f'"i{number}"').replace(f"#{name}", f"#i{number}")
    svg = re.sub(r"\d+\.\d+", lambda found: f"{float(found[0]):.1f}".removesuffix(".0"), svg)
    svg = re.sub(r"\s*\n\s*", " ", svg)
    return svg.replace("<svg ", f'<svg width="{PICTURE_WIDTH}" ', 1) + "\n"


def write_chapter(readme: Path) -> None:
    """Write page and picture anew."""
    text = readme.read_text(encoding="utf-8")
    printed, page = run_commands(chapter_commands(text))
    picture = readme.parent / PICTURE
    picture.parent.mkdir(parents=True, exist_ok=True)
    write_files({readme: fill_outputs(text, printed).encode(), picture: error_picture(page).encode()})


if __name__ == "__main__":
    write_chapter(Path(sys.argv[1]))
