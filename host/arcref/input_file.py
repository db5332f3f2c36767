"""Reading a file that a person gave: its bytes, its text, its JSON, each with a clear error."""

import hashlib
import json
from dataclasses import dataclass
from pathlib import Path

from arcref.input_error import InputError


@dataclass(frozen=True)
class InputFile:
    """A file's bytes, and the SHA-256 of them as hexadecimal text."""

    path: Path
    content: bytes

    @property
    def sha256(self) -> str:
        """SHA-256 of the bytes."""
        return hashlib.sha256(self.content).hexdigest()

    @property
    def record(self) -> dict:
        """The entry for this file in a provenance: its name without the folder, and its SHA-256."""
        return {"file": self.path.name, "sha256": self.sha256}

    def text(self) -> str:
        """The content as UTF-8 text; a byte order mark is dropped. Raises `InputError` when it is not UTF-8."""
        head = self.content[:200]
        # Of plain text in UTF-16 every other byte is zero; a stray zero or two are of something else.
        if head.startswith((b"\xff\xfe", b"\xfe\xff")) or head.count(0) > len(head) // 4:
            problem = "UTF-16 text, as Excel's 'Unicode Text' is; UTF-8 was expected, which Excel calls 'CSV UTF-8'"
            raise InputError.at(self.path, problem)
        if 0 in head:
            raise InputError.at(self.path, "no text: bytes of zero stand in it; UTF-8 text was expected")
        try:
            return self.content.decode("utf-8-sig")
        except UnicodeDecodeError as error:
            row = self.content.count(b"\n", 0, error.start) + 1
            problem = f"not UTF-8 text: byte 0x{self.content[error.start]:02X} at offset {error.start}"
            raise InputError.at(self.path, problem, row=row) from None

    def json_object(self) -> dict:
        """The content as a JSON object. Raises `InputError` when it is none."""
        text = self.text()
        try:
            value = json.loads(text)
        except json.JSONDecodeError as error:
            raise InputError.at(self.path, f"not JSON: {error.msg}", row=error.lineno) from None
        except (ValueError, RecursionError) as error:  # a number of thousands of digits, or thousands of brackets
            raise InputError.at(self.path, f"JSON that cannot be read: {error}") from None
        if not isinstance(value, dict):
            raise InputError.at(self.path, "a JSON object was expected, with keys and values in braces")
        return value


def read_input_file(path) -> InputFile:
    """Read the file at `path`. Raises `InputError` when it is missing, a folder, empty, or cannot be read."""
    path = Path(path)
    try:
        content = path.read_bytes()
    except FileNotFoundError:
        raise InputError.at(path, "there is no such file") from None
    except IsADirectoryError:
        raise InputError.at(path, "is a folder, a file was expected") from None
    except (OSError, ValueError) as error:  # ValueError: a name with a zero byte in it
        raise InputError.at(path, f"cannot be read: {getattr(error, 'strerror', None) or error}") from None
    if not content:
        raise InputError.at(path, "the file is empty")
    return InputFile(path, content)
