"""`arcref registers`: every register by name, read or written."""

import json

import click
from rich.console import Console
from rich.table import Table
from rich.text import Text

from arcref.atomic_file import write_text
from arcref.input_error import InputError
from arcref.instrument.connection import JSON_FILE, with_encoder
from arcref.instrument.register_access import find_register
from arcref.link.register import Access, Field, Register
from arcref.link.registers import REGISTERS


@click.command()
@with_encoder
@click.argument("names", nargs=-1, metavar="[NAME | NAME=VALUE]...")
@click.option("--json", "json_path", type=JSON_FILE, metavar="FILE", help="Write names and values as JSON, too.")
def registers(encoder, names, json_path):
    """Read registers, all unless named, or write them with NAME=VALUE.

    Values are whole numbers, 0x... for hexadecimal. All names and values are looked at before the first is written.
    Those that are named are shown with their meaning.
    """
    requests = [_request(text) for text in names]
    values = {}
    for register, value in requests or [(register, None) for register in _readable()]:
        if value is None:
            values[register.name] = encoder.registers.read(register.name)
        else:
            encoder.registers.write(register.name, value)
            if register.access is Access.WRITE:
                values[register.name] = encoder.registers.read(register.name)
    if json_path:
        write_text(json_path, json.dumps(values, indent=2) + "\n")
    console = Console(highlight=False)
    console.print(_table(values))
    if names:
        for register, _ in requests:
            console.print(f"{register.name}: {register.meaning}", markup=False, soft_wrap=True)


def _readable() -> list[Register]:
    return [register for register in REGISTERS.registers if register.access is not Access.COMMAND]


def _request(text: str) -> tuple[Register, int | None]:
    """The register and the value to write, None to read it. Raises `InputError` for what cannot be asked."""
    name, is_write, value = text.partition("=")
    register = find_register(name.strip())
    if not is_write:
        if register.access is Access.COMMAND:
            raise InputError(f"{register.name} is a command, it can only be written: {register.name}=1")
        return register, None
    try:
        number = int(value, 0)
    except ValueError:
        raise InputError(f"{name}={value}: a whole number was expected behind the =") from None
    if register.access is Access.READ:
        raise InputError(f"the register {register.name} can only be read")
    try:
        register.encode(number)
    except ValueError as error:
        raise InputError(str(error)) from None
    return register, number


def _table(values: dict[str, int]) -> Table:
    table = Table(box=None, pad_edge=False)
    for head in ("address", "register", "value", "unit or fields"):
        table.add_column(head, justify="right" if head == "value" else "left", no_wrap=head != "unit or fields")
    for name, value in values.items():
        register = REGISTERS[name]
        fields = ", ".join(filter(None, (_field_text(field, value) for field in register.fields)))
        table.add_row(f"{register.address:#06x}", name, str(value), Text(register.unit or fields))
    return table


def _field_text(field: Field, value: int) -> str:
    """What a field says: its choice or number, or of a single bit its name where it is 1."""
    number = field.extract(value)
    if field.width == 1 and not field.choices:
        return field.name if number else ""
    return f"{field.name} {field.choices[number] if number < len(field.choices) else number}"
