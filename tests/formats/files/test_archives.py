"""Zip files from anywhere: nothing in them gets outside the folder, or fills the disk."""

import contextlib
import os
import stat
import zipfile
from pathlib import Path

import pytest

from workbench.formats.files import zip_reading
from workbench.formats.files.archives import unpack, unpacked_beside, write_archive
from workbench.model.errors import FileError


def made(path, *entries) -> None:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in entries:
            archive.writestr(name, content)


def test_what_was_written_comes_back(tmp_path):
    (tmp_path / "file").write_bytes(bytes(range(256)) * 5000)
    content = {"a/b.bin": tmp_path / "file", "c.txt": b"hello"}
    write_archive(tmp_path / "x.zip", content)
    assert set(unpack(tmp_path / "x.zip", tmp_path / "out")) == set(content)
    assert (tmp_path / "out/a/b.bin").read_bytes() == (tmp_path / "file").read_bytes()
    assert (tmp_path / "out/c.txt").read_bytes() == b"hello"


def test_the_same_content_gives_the_same_bytes(tmp_path):
    for name in ("x.zip", "y.zip"):
        write_archive(tmp_path / name, {"c.txt": b"hello"})
    assert (tmp_path / "x.zip").read_bytes() == (tmp_path / "y.zip").read_bytes()


def test_a_zip_file_gets_its_name_when_all_of_it_is_on_the_disk(tmp_path, monkeypatch):
    steps, sync, rename = [], os.fsync, Path.replace

    def synced(descriptor):
        steps.append(os.readlink(f"/proc/self/fd/{descriptor}"))
        sync(descriptor)

    def renamed(path, target):
        steps.append("renamed")
        return rename(path, target)

    monkeypatch.setattr(os, "fsync", synced)
    monkeypatch.setattr(Path, "replace", renamed)
    write_archive(tmp_path / "kept.zip", {"one": b"1"})
    assert "partial" in steps[0]
    assert steps[1:] == ["renamed", str(tmp_path)]


def test_a_file_that_cannot_be_read_leaves_no_half_of_a_zip_file(tmp_path):
    with pytest.raises(FileError, match="No such file"):
        write_archive(tmp_path / "x.zip", {"a": b"1", "b": tmp_path / "missing"})
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "name",
    [
        "../evil",
        "a/../../evil",
        "/etc/evil",
        "C:\\evil",
        "a\\b",
        "a//b",
        "./a",
        "a/./b",
        "a\nb",
        "...",
        "x" * 121,
        "ä/b",
    ],
)
def test_names_that_lead_elsewhere_are_refused(tmp_path, name):
    made(tmp_path / "x.zip", ("good", "1"), (name, "2"))
    with pytest.raises(FileError, match="no plain path"):
        unpack(tmp_path / "x.zip", tmp_path / "out")
    assert not (tmp_path / "evil").exists() and not (tmp_path / "out").exists()


@pytest.mark.filterwarnings("ignore:Duplicate name")
@pytest.mark.parametrize("names", [("a", "a"), ("a/b", "A/b")])
def test_a_file_named_twice_is_refused(tmp_path, names):
    made(tmp_path / "x.zip", *((name, "1") for name in names))
    with pytest.raises(FileError, match="twice"):
        unpack(tmp_path / "x.zip", tmp_path / "out")


def test_links_are_refused(tmp_path):
    link = zipfile.ZipInfo("link")
    link.external_attr = (stat.S_IFLNK | 0o777) << 16
    with zipfile.ZipFile(tmp_path / "x.zip", "w") as archive:
        archive.writestr(link, "/etc/passwd")
    with pytest.raises(FileError, match="is no plain file"):
        unpack(tmp_path / "x.zip", tmp_path / "out")


def test_a_file_that_is_a_folder_too_is_refused(tmp_path):
    made(tmp_path / "x.zip", ("a", "1"), ("a/b", "2"))
    with pytest.raises(FileError):
        unpack(tmp_path / "x.zip", tmp_path / "out")


def test_a_bomb_is_refused_before_anything_is_written(tmp_path):
    made(tmp_path / "x.zip", ("zeros", bytes(20 * 2**20)))
    assert (tmp_path / "x.zip").stat().st_size < 30_000
    with pytest.raises(FileError, match="unpacks to more than"):
        unpack(tmp_path / "x.zip", tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_too_many_files_are_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(zip_reading, "MOST_FILES", 3)
    made(tmp_path / "x.zip", *((str(number), "1") for number in range(4)))
    with pytest.raises(FileError, match="3 files"):
        unpack(tmp_path / "x.zip", tmp_path / "out")


def test_content_that_is_longer_than_announced_is_not_written(tmp_path):
    made(tmp_path / "x.zip", ("a", b"0123456789" * 1000))
    raw = bytearray((tmp_path / "x.zip").read_bytes())
    # The uncompressed size in header and directory, PKWARE APPNOTE 4.3.7 and 4.3.12.
    for place in (22, raw.rindex(b"PK\x01\x02") + 24):
        raw[place : place + 4] = (100).to_bytes(4, "little")
    (tmp_path / "x.zip").write_bytes(raw)
    with pytest.raises(FileError, match="longer than it says"):
        unpack(tmp_path / "x.zip", tmp_path / "out")
    assert (tmp_path / "out/a").stat().st_size <= 100


@pytest.mark.parametrize("content", [b"", b"no zip", b"PK\x03\x04" + bytes(50)])
def test_what_is_no_zip_file_is_refused(tmp_path, content):
    (tmp_path / "x.zip").write_bytes(content)
    with pytest.raises(FileError, match="no zip file"):
        unpack(tmp_path / "x.zip", tmp_path / "out")


def test_damage_anywhere_is_refused_or_harmless(tmp_path):
    write_archive(tmp_path / "x.zip", {"a": bytes(range(200)), "b/c": b"hello" * 20})
    good = (tmp_path / "x.zip").read_bytes()
    for place in range(0, len(good), 3):
        raw = bytearray(good)
        raw[place] ^= 0x41
        (tmp_path / "y.zip").write_bytes(raw)
        out = tmp_path / f"out-{place}"
        with contextlib.suppress(FileError):
            unpack(tmp_path / "y.zip", out)
    assert {one.name.split("-")[0] for one in tmp_path.iterdir()} <= {"x.zip", "y.zip", "out"}


@pytest.mark.parametrize("packing", [zipfile.ZIP_LZMA, zipfile.ZIP_BZIP2])
def test_damage_is_refused_however_it_is_packed(tmp_path, packing):
    with zipfile.ZipFile(tmp_path / "x.zip", "w", packing) as archive:
        archive.writestr("a", b"hello" * 100)
    raw = bytearray((tmp_path / "x.zip").read_bytes())
    raw[50] ^= 0xFF
    (tmp_path / "x.zip").write_bytes(raw)
    with pytest.raises(FileError):
        unpack(tmp_path / "x.zip", tmp_path / "out")


def test_a_name_that_is_no_utf_8_is_refused(tmp_path):
    made(tmp_path / "x.zip", ("ä", "1"))
    raw = (tmp_path / "x.zip").read_bytes().replace("ä".encode(), b"\xff\xfe")
    (tmp_path / "x.zip").write_bytes(raw)
    with pytest.raises(FileError, match="no zip file"):
        unpack(tmp_path / "x.zip", tmp_path / "out")


def test_a_folder_beside_goes_with_its_block(tmp_path):
    made(tmp_path / "x.zip", ("a/b", "1"))
    with unpacked_beside(tmp_path / "x.zip", tmp_path / "here") as place:
        assert (place / "a/b").read_text() == "1" and place.parent == tmp_path / "here"
    assert list((tmp_path / "here").iterdir()) == []
