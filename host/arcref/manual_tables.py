"""Tables of the manual, in Markdown, printed from the contract so that no table can say something else.

README.md and docs/ hold them between marks; `make manual` writes them there anew, and a test fails when a page and
the contract differ.
"""

import re
import textwrap
from pathlib import Path

from arcref.atomic_file import write_text
from arcref.calibration.metadata_key import EVERY
from arcref.calibration.metadata_keys import METADATA_KEYS
from arcref.flags import FAULT_FLAGS, FLAG_MEANINGS
from arcref.input_error import InputError
from arcref.link.register import Access, Field, Register
from arcref.link.registers import REGISTERS
from arcref.position_frame import FRAME_FIELDS

PAGE_COLUMNS = 112
"""Widest line of a command's output in a page."""


def markdown_table(head: list[str], rows: list[list[str]]) -> str:
    """A Markdown table."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def flag_table() -> str:
    """Every flag: bit, name, what it says, what to do."""
    rows = [
        [
            str(flag.bit_length() - 1),
            meaning.name,
            "fault" if flag & FAULT_FLAGS else "state",
            meaning.meaning,
            meaning.action,
        ]
        for flag, meaning in FLAG_MEANINGS.items()
    ]
    return markdown_table(["bit", "flag", "kind", "what happened", "what to do"], rows)


def frame_table() -> str:
    """The fields of the position frame."""
    rows = [
        [
            f"{field.high}..{field.low}" if field.width > 1 else str(field.high),
            field.name.replace("_", " "),
            field.meaning,
        ]
        for field in FRAME_FIELDS
    ]
    return markdown_table(["bits", "field", "meaning"], rows)


def metadata_table() -> str:
    """The metadata keys of run files."""
    rows = [
        [
            f"`{key.name}`",
            key.group,
            "all" if key.kinds == EVERY else ", ".join(key.kinds),
            {None: "text", "1": "number"}.get(key.unit, key.unit),
            key.description,
        ]
        for key in METADATA_KEYS
    ]
    return markdown_table(["key", "group", "runs", "unit", "meaning"], rows)


def register_table() -> str:
    """Every register: address, name, width, access, reset value, unit, and what it says with its fields."""
    rows = []
    for register in REGISTERS.registers:
        meaning = " ".join([register.meaning, *(_field_sentence(field) for field in register.fields)])
        if register.largest is not None:
            meaning += f" At most {register.largest}."
        reset = "" if register.access is Access.COMMAND or not _has_reset(register) else f"{register.reset:#x}"
        width = f"{register.width}{' signed' if register.signed else ''}"
        rows.append(
            [
                f"{register.address:#06x}",
                f"`{register.name}`",
                width,
                register.access.value,
                reset,
                register.unit,
                meaning,
            ]
        )
    return markdown_table(["address", "register", "bits", "access", "reset", "unit", "meaning"], rows)


def _has_reset(register: Register) -> bool:
    """Settings start from their reset value; of what is only read, constants state it."""
    return register.access is Access.WRITE or register.reset != 0


def _field_sentence(field: Field) -> str:
    bits = f"{field.low + field.width - 1}..{field.low}" if field.width > 1 else f"{field.low}"
    choices = ", ".join(f"{number} {choice}" for number, choice in enumerate(field.choices))
    return f"Bit{'s' * (field.width > 1)} {bits} `{field.name}`: {field.meaning}" + (f" {choices}." if choices else "")


def window_table() -> str:
    """The memories that stand at addresses of their own."""
    rows = [
        [f"{window.address:#06x}", f"`{window.name}`", str(window.words), window.meaning]
        for window in REGISTERS.windows
    ]
    return markdown_table(["from", "window", "words", "meaning"], rows)


def fill_page(text: str, tables: dict[str, str]) -> str:
    """`text` with what stands between `<!-- table NAME -->` and `<!-- end NAME -->` replaced, for each table named.

    Raises `InputError` for a mark without a table of that name.
    """

    def filled(match):
        name = match["name"]
        if name not in tables:
            raise InputError(f"the page asks for a table {name!r}, there are {', '.join(sorted(tables))}")
        return f"<!-- table {name} -->\n{tables[name]}\n<!-- end {name} -->"

    return re.sub(r"<!-- table (?P<name>\w+) -->.*?<!-- end (?P=name) -->", filled, text, flags=re.DOTALL)


def fill_pages(pages: list[str], tables: dict[str, str]) -> None:
    """Write the tables anew into each page."""
    for page in pages:
        write_text(page, fill_page(Path(page).read_text(encoding="utf-8"), tables))


def fill_outputs(readme: str, printed: dict[str, str]) -> str:
    """`readme` with what stands between `<!-- output NAME -->` and `<!-- end NAME -->` replaced, for each name."""
    for name, text in printed.items():
        lines = [part for line in text.splitlines() for part in _wrapped(line)]
        block = "".join(f"    {line.rstrip()}\n" for line in lines)
        marks = re.compile(rf"(<!-- output {name} -->\n).*?(<!-- end {name} -->)", re.DOTALL)
        readme = marks.sub(lambda found, block=block: found[1] + block + found[2], readme)
    return readme


def _wrapped(line: str) -> list[str]:
    return textwrap.wrap(line, PAGE_COLUMNS, drop_whitespace=True, replace_whitespace=False, break_long_words=False)


HOST_TABLES = {
    "flags": flag_table(),
    "frame": frame_table(),
    "metadata": metadata_table(),
    "registers": register_table(),
    "windows": window_table(),
}
"""Tables that the host's contract gives."""
