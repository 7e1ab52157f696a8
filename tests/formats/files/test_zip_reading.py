"""Zip files of other programs: read where every reader finds the same in them."""

import io
import shutil
import struct
import zipfile

import pytest
from hypothesis import given, settings
from mutations import mutated, only_file_errors

from workbench.formats.files.archives import unpack, write_archive
from workbench.formats.files.zip_frame import blocks_of
from workbench.formats.files.zip_reading import files_in
from workbench.model.errors import FileError

CONTENT = {"a/b.bin": bytes(range(256)) * 50, "c.txt": b"hello"}


class Pipe(io.RawIOBase):
    """Where nobody can go back."""

    def __init__(self):
        self.content = b""

    def writable(self):
        return True

    def write(self, block):
        self.content += bytes(block)
        return len(block)


def found_in(content):
    file = io.BytesIO(content)
    return {one.name: b"".join(blocks_of(file, one)) for one in files_in(file)}


@pytest.mark.parametrize("is_large", [False, True])
@pytest.mark.parametrize("target", [io.BytesIO, Pipe])
@pytest.mark.parametrize("method", [zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED])
def test_zip_files_of_python_are_read(target, method, is_large):
    out = target()
    with zipfile.ZipFile(out, "w", method) as archive:
        for name, content in CONTENT.items():
            with archive.open(name, "w", force_zip64=is_large) as file:
                file.write(content)
    made = out.content if target is Pipe else out.getvalue()
    if target is Pipe and method == zipfile.ZIP_STORED:
        # From the front nobody knows where such a file ends.
        with pytest.raises(ValueError, match="does not say how long"):
            found_in(made)
    else:
        assert found_in(made) == CONTENT


def test_folders_are_left_out(tmp_path):
    for name, content in CONTENT.items():
        (tmp_path / "in" / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "in" / name).write_bytes(content)
    (tmp_path / "in" / "nothing").mkdir()
    path = shutil.make_archive(str(tmp_path / "x"), "zip", tmp_path / "in")
    with zipfile.ZipFile(path) as archive:
        assert {"a/", "nothing/"} < set(archive.namelist())
    assert set(unpack(tmp_path / "x.zip", tmp_path / "out")) == set(CONTENT)


def test_something_in_the_place_of_a_folder_is_found():
    hidden = b"\3\0hidden"
    shared = struct.pack("<5H3L2H", 20, 0, zipfile.ZIP_DEFLATED, 0, 33, 0, len(hidden), 0, 2, 0)
    header, listed = b"PK\3\4" + shared, b"PK\1\2\x14\0" + shared
    start = len(header) + 2 + len(hidden)
    end = b"PK\5\6" + struct.pack("<4H2LH", 0, 0, 1, 1, len(listed) + 16, start, 0)
    made = header + b"a/" + hidden + listed + bytes(14) + b"a/" + end
    assert zipfile.ZipFile(io.BytesIO(made)).namelist() == ["a/"]
    with pytest.raises(ValueError, match="bytes behind its end"):
        found_in(made)


def test_a_zip64_end_counts_where_the_other_one_agrees(tmp_path):
    write_archive(tmp_path / "x.zip", CONTENT)
    made = (tmp_path / "x.zip").read_bytes()
    _, _, count, _, size, start, _ = struct.unpack("<4H2LH", made[-18:])

    def with_large(end, count=count, size=size, start=start):
        large = b"PK\6\6" + struct.pack("<Q2H2L4Q", 44, 45, 45, 0, 0, count, count, size, start)
        place = b"PK\6\7" + struct.pack("<LQL", 0, len(made) - 22, 1)
        return made[:-22] + large + place + end

    full = b"PK\5\6" + struct.pack("<4H2LH", 0, 0, 0xFFFF, 0xFFFF, 2**32 - 1, 2**32 - 1, 0)
    assert found_in(with_large(made[-22:])) == found_in(with_large(full)) == CONTENT
    for wrong in ({"count": 1}, {"size": size - 1}, {"start": start - 1}, {"start": 2**64 - 1}):
        for end in (made[-22:], full):
            with pytest.raises(ValueError):
                found_in(with_large(end, **wrong))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("bent")


def packed():
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in CONTENT.items():
            archive.writestr(name, content)
    return out.getvalue()


@settings(max_examples=300)
@given(content=mutated(packed()))
def test_a_broken_zip_file_is_read_or_refused_in_one_sentence(folder, content):
    def read(path):
        shutil.rmtree(folder / "out", ignore_errors=True)
        return unpack(path, folder / "out")

    only_file_errors(folder / "x.zip", content, read)


def test_a_comment_or_something_behind_is_told(tmp_path):
    (tmp_path / "x.zip").write_bytes(packed() + b"\0")
    with pytest.raises(FileError, match="no end of a zip file at its end"):
        unpack(tmp_path / "x.zip", tmp_path / "out")
