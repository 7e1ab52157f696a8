"""Zip files as the workbench packs them: every byte around the contents follows from them."""

import io
import itertools
import tracemalloc
import zipfile
import zlib

import pytest

from workbench.formats.files.archives import write_archive
from workbench.formats.files.zip_frame import (
    DEFLATED,
    LARGEST_FILE,
    Member,
    blocks_of,
    directory_of,
    members_of,
    name_problems,
)
from workbench.model.errors import FileError

CONTENT = {"a/b.bin": bytes(range(256)) * 50, "c.txt": b"hello", "empty": b""}


def by_zipfile(file, content):
    """As workbench 0.2.0 packed: with `zipfile` of Python."""
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED, compresslevel=6) as archive:
        for name, one in content.items():
            about = zipfile.ZipInfo(name)
            about.compress_type = zipfile.ZIP_DEFLATED
            about.external_attr = 0o644 << 16
            archive.writestr(about, one)


def test_it_is_what_zipfile_writes(tmp_path):
    write_archive(tmp_path / "x.zip", CONTENT)
    by_zipfile(tmp_path / "y.zip", CONTENT)
    assert (tmp_path / "x.zip").read_bytes() == (tmp_path / "y.zip").read_bytes()


@pytest.mark.extensive
@pytest.mark.parametrize("count", [65_535, 65_536])
def test_it_is_what_zipfile_writes_also_with_very_many_files(tmp_path, count):
    content = dict.fromkeys(map(str, range(count)), b"x")
    write_archive(tmp_path / "x.zip", content)
    by_zipfile(tmp_path / "y.zip", content)
    assert (tmp_path / "x.zip").read_bytes() == (tmp_path / "y.zip").read_bytes()
    with (tmp_path / "x.zip").open("rb") as file:
        assert [member.name for member in members_of(file)] == list(content)


class Far(io.BytesIO):
    """A file whose first gigabytes are left out."""

    start = 0

    def tell(self):
        return super().tell() + self.start


@pytest.mark.parametrize("size", [1, 2**30, LARGEST_FILE])
def test_it_is_what_zipfile_writes_also_beyond_two_and_four_gigabytes(size):
    members, place = [], 0
    archive = zipfile.ZipFile(Far(), "w")
    for number in range(6):
        members.append(Member(str(number), DEFLATED, 7, size, size, place + 31))
        about = zipfile.ZipInfo(str(number))
        about.CRC, about.compress_size, about.file_size, about.header_offset = 7, size, size, place
        about.compress_type, about.external_attr = zipfile.ZIP_DEFLATED, 0o644 << 16
        archive.filelist.append(about)
        place += 31 + size
    archive.fp.start = archive.start_dir = place
    archive._write_end_record()
    assert directory_of(members) == archive.fp.getvalue()
    archive.fp = None


def test_every_changed_added_or_missing_byte_is_found(tmp_path):
    write_archive(tmp_path / "x.zip", CONTENT)
    good = (tmp_path / "x.zip").read_bytes()
    bent = [good[:at] + bytes([good[at] ^ 1]) + good[at + 1 :] for at in range(len(good))]
    bent += [good[:at] + good[at + 1 :] for at in range(len(good))]
    bent += [good[:at] + b"\0" + good[at:] for at in range(len(good) + 1)]
    for number, content in enumerate(bent):
        file = io.BytesIO(content)
        with pytest.raises(ValueError):
            found = {one.name: b"".join(blocks_of(file, one)) for one in members_of(file)}
            # Some bits at the end of what is packed mean nothing.
            assert found != CONTENT or number < len(good)
            raise ValueError


def test_what_hides_behind_a_packed_file_is_not_taken_into_memory():
    content, hidden = zlib.compress(b"hello", wbits=-15), bytes(2**26)
    file = io.BytesIO(content + hidden)
    one = Member("a", DEFLATED, zlib.crc32(b"hello"), len(content + hidden), 5, 0)
    tracemalloc.start()
    with pytest.raises(ValueError, match="bytes behind its end"):
        list(blocks_of(file, one))
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert most < 2**23


def test_what_unpacks_to_more_than_announced_is_not_unpacked():
    content = zlib.compress(bytes(2**27), wbits=-15)
    one = Member("a", DEFLATED, 0, len(content), 10, 0)
    tracemalloc.start()
    with pytest.raises(ValueError, match="longer than it says"):
        list(blocks_of(io.BytesIO(content), one))
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert most < 2**23


def test_content_comes_whole_however_it_is_packed(tmp_path):
    for level, size in itertools.product((0, 1, 9), (0, 1, 2**20, 2**20 + 1, 3 * 2**20)):
        content = bytes(size)
        packed = zlib.compress(content, level, wbits=-15)
        one = Member("a", DEFLATED, zlib.crc32(content), len(packed), size, 0)
        assert b"".join(blocks_of(io.BytesIO(packed), one)) == content


def test_a_file_that_could_not_be_read_again_is_not_written(tmp_path, monkeypatch):
    monkeypatch.setattr("workbench.formats.files.archives.LARGEST_FILE", 100)
    with pytest.raises(FileError, match="'c' is longer than"):
        write_archive(tmp_path / "x.zip", {"a": bytes(100), "c": bytes(101)})
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("names", "problem"),
    [
        (["a", "a"], "twice"),
        (["a/b", "A/B"], "twice"),
        (["a/b", "A"], "a file and a folder"),
        (["a", "a/b/c", "a.b"], "a file and a folder"),
        (["a."], "no plain path"),
        (["a "], "no plain path"),
        ([" a"], "no plain path"),
        (["a/" * 300 + "b"], "no plain path"),
        (["a\0b"], "no plain path"),
    ],
)
def test_names_that_a_system_may_change_are_told(names, problem):
    assert [problem in one for one in name_problems(names)] == [True]


def test_names_below_one_folder_are_no_matter():
    assert list(name_problems(["a/b", "A/c", "a.b", "a b/-.c", ".d"], ["a", "e"])) == []
