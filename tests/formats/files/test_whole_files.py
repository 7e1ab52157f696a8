import errno
import os
import re
from concurrent.futures import ThreadPoolExecutor, wait
from contextlib import suppress
from pathlib import Path

import pytest

from workbench.formats.files import whole_files
from workbench.formats.files.whole_files import file_name, read_whole, write_upload, write_whole
from workbench.model.errors import FileError, InputError


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


def test_a_pipe_that_nobody_writes_to_is_told(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setattr(whole_files, "SILENCE", 0.05)
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(FileError, match=r"through which nothing has come for 0\.05 s"):
        read_whole(tmp_path / "pipe", 100)


@pytest.mark.parametrize("length", [10, 100, 101, 300_000])
def test_what_comes_through_a_pipe_in_pieces_is_read_to_its_end(tmp_path: Path, length) -> None:
    os.mkfifo(tmp_path / "pipe")
    content = os.urandom(length)

    def write() -> None:
        with suppress(BrokenPipeError), open(tmp_path / "pipe", "wb", buffering=0) as pipe:
            for start in range(0, length, 70_000):
                pipe.write(content[start : start + 70_000])

    with ThreadPoolExecutor(1) as pool:
        writing = pool.submit(write)
        if length > 100:
            with pytest.raises(FileError, match="is longer than"):
                read_whole(tmp_path / "pipe", 100)
        else:
            assert read_whole(tmp_path / "pipe", 100) == content
        writing.result()


def test_a_file_and_its_name_are_on_the_disk_before_it_is_said(tmp_path: Path, monkeypatch) -> None:
    done: list[str] = []
    sync, replace = os.fsync, Path.replace

    def noted(number: int) -> None:
        done.append("folder" if os.path.isdir(f"/proc/self/fd/{number}") else "file")
        sync(number)

    def renamed(self: Path, target: Path) -> Path:
        done.append("rename")
        return replace(self, target)

    monkeypatch.setattr(os, "fsync", noted)
    monkeypatch.setattr(Path, "replace", renamed)
    write_whole(tmp_path / "a", b"x")
    assert done == ["file", "rename", "folder"]


def test_a_folder_is_refused_and_keeps_no_descriptor(tmp_path: Path) -> None:
    before = len(os.listdir("/proc/self/fd"))
    for _ in range(20):
        with pytest.raises(FileError, match="Is a directory"):
            read_whole(tmp_path, 100)
    assert len(os.listdir("/proc/self/fd")) < before + 20


def test_what_is_typed_at_a_terminal_is_read_to_its_end() -> None:
    keyboard, terminal = os.openpty()
    try:
        with ThreadPoolExecutor(1) as pool:
            reading = pool.submit(read_whole, Path(os.ttyname(terminal)), 100)
            # It begins before anything is typed.
            assert not wait([reading], 0.2).done
            os.write(keyboard, b"typed\n\x04")
            assert reading.result() == b"typed\n"
    finally:
        os.close(keyboard)
        os.close(terminal)


def test_a_folder_that_cannot_be_synced_holds_the_file_all_the_same(
    tmp_path: Path, monkeypatch
) -> None:
    sync = os.fsync

    def only_files(number: int) -> None:
        if os.path.isdir(f"/proc/self/fd/{number}"):
            raise OSError(errno.EINVAL, "Invalid argument")
        sync(number)

    monkeypatch.setattr(os, "fsync", only_files)
    write_whole(tmp_path / "a", b"x")
    assert (tmp_path / "a").read_bytes() == b"x"


@pytest.mark.parametrize(
    "name",
    ["", ".", "..", "/etc/passwd", "../part.stl", "C:\\a.stl", "a\0.stl", "a\n.stl", "\udc80"],
)
def test_a_name_that_no_file_has_is_refused_in_a_sentence(name) -> None:
    with (
        pytest.raises(InputError, match="is not the name of a file"),
        write_upload(name, b"content"),
    ):
        pytest.fail("it was taken")


@pytest.mark.parametrize("name", ["part.stl", "Bild 3.06.ply", ".hidden", "ä" * 200, "..a"])
def test_a_file_that_was_sent_is_there_for_a_while_by_its_name(name) -> None:
    with write_upload(name, memoryview(b"content")) as file:
        assert file.read_bytes() == b"content"
        assert name.endswith(file.name)
    assert not file.parent.exists()
