import os
import re
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from workbench.formats.files.whole_files import file_name, read_whole, write_whole
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


def test_who_may_read_a_file_stays_as_it_was(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(b"old")
    (tmp_path / "a").chmod(0o640)
    write_whole(tmp_path / "a", b"new")
    assert (tmp_path / "a").stat().st_mode & 0o777 == 0o640


def test_a_name_as_long_as_the_file_system_has_them_can_be_written(tmp_path: Path) -> None:
    write_whole(tmp_path / ("a" * 255), b"new")
    assert (tmp_path / ("a" * 255)).read_bytes() == b"new"


def test_threads_that_write_the_same_file_do_not_mix(tmp_path: Path) -> None:
    contents = [bytes([k]) * 300_000 for k in range(4)]

    def write(content: bytes) -> None:
        for _ in range(20):
            write_whole(tmp_path / "a", content)
            assert (tmp_path / "a").read_bytes() in contents

    with ThreadPoolExecutor() as threads:
        list(threads.map(write, contents))
    assert [item.name for item in tmp_path.iterdir()] == ["a"]


def test_every_name_gives_a_file_name_of_its_own() -> None:
    names = ["../a", ".._a", "/etc/a", "a b", "a_b", "ä", "_", "a" * 300, "a" * 301]
    made = [file_name(name) for name in names]
    assert len(set(made)) == len(names)
    assert all(re.fullmatch(r"[A-Za-z0-9_.-]{1,120}", one) for one in made)
    assert file_name("right_link-1.a") == "right_link-1.a"


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
