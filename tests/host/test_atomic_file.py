import os
import stat

import pytest

from arcref import atomic_file
from arcref.atomic_file import write_bytes, write_files, write_text
from arcref.input_error import InputError


def test_content_is_written_as_given(tmp_path):
    write_bytes(tmp_path / "a", b"\x00\r\n\xff")
    write_text(tmp_path / "b", "ä\n")
    assert (tmp_path / "a").read_bytes() == b"\x00\r\n\xff"
    assert (tmp_path / "b").read_bytes() == b"\xc3\xa4\n"
    assert sorted(os.listdir(tmp_path)) == ["a", "b"]


def test_an_old_file_is_replaced(tmp_path):
    path = tmp_path / "a"
    path.write_text("old and longer")
    write_text(path, "new")
    assert path.read_text() == "new"


def test_the_umask_decides_who_may_read(tmp_path):
    before = os.umask(0o027)
    try:
        write_text(tmp_path / "a", "x")
    finally:
        os.umask(before)
    assert stat.S_IMODE((tmp_path / "a").stat().st_mode) == 0o640


def test_a_link_stays_a_link(tmp_path):
    (tmp_path / "folder").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "folder" / "file")
    write_text(tmp_path / "link", "x")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "folder" / "file").read_text() == "x"


def test_a_missing_folder_is_bad_use(tmp_path):
    with pytest.raises(InputError, match=r"none/a: cannot be written: No such file or directory"):
        write_text(tmp_path / "none" / "a", "x")


def test_a_folder_is_not_replaced(tmp_path):
    with pytest.raises(InputError, match="is a folder"):
        write_text(tmp_path, "x")


def test_when_one_of_several_fails_none_is_changed(tmp_path):
    (tmp_path / "a").write_text("old")
    with pytest.raises(InputError, match="none/b"):
        write_files({tmp_path / "a": b"new", tmp_path / "none" / "b": b"new"})
    assert (tmp_path / "a").read_text() == "old"
    assert os.listdir(tmp_path) == ["a"]


def test_a_full_disk_leaves_the_old_file(tmp_path, monkeypatch):
    def full(descriptor):
        raise OSError(28, "No space left on device")

    (tmp_path / "a").write_text("old")
    monkeypatch.setattr(atomic_file.os, "fsync", full)
    with pytest.raises(InputError, match="a: cannot be written: No space left on device"):
        write_text(tmp_path / "a", "new")
    assert (tmp_path / "a").read_text() == "old"
    assert os.listdir(tmp_path) == ["a"]
