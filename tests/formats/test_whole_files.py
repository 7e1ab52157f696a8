import os
from pathlib import Path

import pytest

from workbench.formats.whole_files import read_whole, write_whole
from workbench.model.errors import FileError


def test_a_file_of_the_largest_size_is_read(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(b"12345")
    assert read_whole(tmp_path / "a", 5) == b"12345"
    with pytest.raises(FileError, match="is longer than"):
        read_whole(tmp_path / "a", 4)


def test_reading_a_device_without_an_end_stops() -> None:
    with pytest.raises(FileError, match="is longer than"):
        read_whole(Path("/dev/zero"), 1000)


def test_writing_replaces_the_whole_file_and_leaves_nothing_else(tmp_path: Path) -> None:
    write_whole(tmp_path / "a", b"a long first content")
    write_whole(tmp_path / "a", b"second")
    assert (tmp_path / "a").read_bytes() == b"second"
    assert [item.name for item in tmp_path.iterdir()] == ["a"]


def test_writing_follows_a_link(tmp_path: Path) -> None:
    (tmp_path / "real").write_bytes(b"old")
    (tmp_path / "link").symlink_to(tmp_path / "real")
    write_whole(tmp_path / "link", b"new")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "real").read_bytes() == b"new"


def test_writing_into_a_pipe_does_not_replace_it() -> None:
    reading, writing = os.pipe()
    try:
        write_whole(Path(f"/proc/self/fd/{writing}"), b"through")
        assert os.read(reading, 100) == b"through"
    finally:
        os.close(reading)
        os.close(writing)


@pytest.mark.parametrize("name", ["none/a", "", "a\0b"])
def test_a_place_that_cannot_be_written_is_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(FileError):
        write_whole(tmp_path / name, b"x")
    assert list(tmp_path.iterdir()) == []
