"""Files written whole or not at all.

The content goes to a temporary file in the same folder, is flushed to the disk, and takes the final name in one step.
A reader, or a power cut, meets the old file or the new one and never a half of either.
"""

import contextlib
import os
import secrets
from collections.abc import Mapping
from pathlib import Path

from arcref.input_error import InputError


def write_bytes(path, content: bytes) -> None:
    """Write `content` to `path`. Raises `InputError` when the file cannot be written."""
    write_files({path: content})


def write_text(path, content: str) -> None:
    """Write `content` to `path` as UTF-8, line ends as they are. Raises `InputError` when it cannot be written."""
    write_files({path: content.encode()})


def write_files(contents: Mapping) -> None:
    """Write several files, `{path: bytes}`; none takes its name before the content of all is on the disk.

    Raises `InputError`, which names the file, when one cannot be written; then none is changed, except when a
    renaming itself fails, which leaves the files renamed before it.
    """
    waiting: list[tuple[str, str, object]] = []
    path = None
    try:
        for path, content in contents.items():
            # A symbolic link stays one: the file it points at is replaced.
            target = os.path.realpath(path)
            if os.path.isdir(target):
                raise IsADirectoryError(21, "is a folder, a file name was expected")
            aside = _write_aside(target, content)
            waiting.append((aside, target, path))
        while waiting:
            aside, target, path = waiting[0]
            os.replace(aside, target)
            waiting.pop(0)
            _sync_folder(os.path.dirname(target))
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror or error}") from error
    finally:
        for aside, _, _ in waiting:
            with contextlib.suppress(OSError):
                os.unlink(aside)


def _write_aside(target: str, content: bytes) -> str:
    folder, name = os.path.split(target)
    # The name is shortened so that the temporary one keeps within a file system's 255 bytes.
    aside = os.path.join(folder, f".{name[:40]}.{secrets.token_hex(6)}.tmp")
    # Opened with 0o666, not by `tempfile`, so that the user's umask decides who may read the result.
    descriptor = os.open(aside, os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0), 0o666)
    try:
        with os.fdopen(descriptor, "wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
    except BaseException:
        Path(aside).unlink(missing_ok=True)
        raise
    return aside


def _sync_folder(folder: str) -> None:
    """Bring the new name itself to the disk. Not every system lets a folder be opened for that."""
    with contextlib.suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
