"""What `arcref build` prints, in README.md, from the record of a real build.

Run as a module: `readme_build build/ulx3s/build.json README.md`. `make manual` does so where that board was built.
"""

import sys
from pathlib import Path

from arcref.atomic_file import write_text
from arcref.input_file import read_input_file
from arcref.manual_tables import fill_outputs
from arcref_gateware.boards.build_command import LOG_NAME
from arcref_gateware.boards.build_figures import printed
from arcref_gateware.boards.build_record import RECORD_NAME
from arcref_gateware.boards.place_and_route import DESIGN, SUFFIX


def build_output(record: dict) -> str:
    """The lines that the build printed at its end."""
    folder = Path("build") / record["board"]
    return printed(record, [folder / name for name in (f"{DESIGN}{SUFFIX[record['family']]}", RECORD_NAME, LOG_NAME)])


if __name__ == "__main__":
    build, readme = sys.argv[1:]
    text = build_output(read_input_file(Path(build)).json_object())
    write_text(readme, fill_outputs(Path(readme).read_text(encoding="utf-8"), {"build": text}))
