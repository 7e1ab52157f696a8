"""What the zip file around evidence may hold beside the files.

`verify.py` carries it along, so it imports nothing that `verify.py` does not.
"""

import struct
import zipfile
from collections.abc import Iterator
from pathlib import Path


def frame_problems(path: Path, archive: zipfile.ZipFile) -> Iterator[str]:
    """What a zip file can hide: bytes between files, the same name twice, comments."""
    names = [one.filename for one in archive.infolist()]
    for name in sorted({name for name in names if names.count(name) > 1}):
        yield f"{name} is there twice"
    if archive.comment or any(one.comment or one.extra for one in archive.infolist()):
        yield "the zip file has comments or fields that no bundle has"
    expected = 0
    with path.open("rb") as file:
        for one in sorted(archive.infolist(), key=lambda one: one.header_offset):
            if one.header_offset != expected:
                yield f"there are bytes before {one.filename} that belong to no file"
            file.seek(one.header_offset + 26)
            name, extra = struct.unpack("<HH", file.read(4))
            if extra:
                yield f"{one.filename} has fields in front of it that no bundle has"
            expected = one.header_offset + 30 + name + extra + one.compress_size
        if archive.start_dir != expected:
            yield "there are bytes before the directory that belong to no file"
        file.seek(-22, 2)
        if file.read(4) != b"PK\5\6":
            yield "there are bytes after the end of the zip file"
