"""Zip files that are packed honestly in another way, or are something else beside."""

import io
import subprocess
import tarfile
import tempfile
from pathlib import Path
from random import Random

from zip_forging import DEFLATED, STORED, Part, Zip, deflated, header, trick
from zip_tricks import REPORT, TEXT, another_zip, restated


@trick
def pictures_of_disks_and_tapes(one: Zip, draw: Random) -> None:
    """A signed file in which other programs see a disk or a tape with another report."""
    name = f"certificates/{draw.randrange(9)}.bin".encode()
    start = 30 + len(name)
    if draw.random() < 0.5:
        with tempfile.TemporaryDirectory() as folder:
            (Path(folder) / REPORT.decode()).write_bytes(TEXT)
            words = ["bsdtar", "-c", "--format", "iso9660", "-f", "-", "-C", folder, "."]
            disk = subprocess.run(words, capture_output=True, check=True).stdout
        content = disk[start:]
    else:
        content = _tape(name, start, draw)
    one.parts.insert(0, Part(name, content, STORED))
    restated(one)


def _tape(name: bytes, start: int, draw: Random) -> bytes:
    """A file that is a tape from its zip header on: the checksums of both have to agree."""
    made = io.BytesIO()
    with tarfile.open(fileobj=made, mode="w", format=tarfile.USTAR_FORMAT) as tape:
        for each, text in (("x" * 90, b""), (REPORT.decode(), TEXT)):
            about = tarfile.TarInfo(each)
            about.size = len(text)
            tape.addfile(about, io.BytesIO(text))
    block = bytearray(made.getvalue())
    wanted = 0
    while True:
        block[265:273] = b"%08x" % draw.randrange(2**32)
        block[148:156] = b"%06o\0 " % wanted
        part = Part(name, bytes(block[start:]), STORED)
        whole = header(part) + part.content
        found = sum(whole[:148]) + 8 * 32 + sum(whole[156:512])
        if found == wanted:
            return part.content
        wanted = found


@trick
def another_order_and_level(one: Zip, draw: Random) -> None:
    """Honest: nothing but the order of the files and how well they are packed is another."""
    draw.shuffle(one.parts)
    for part in one.parts:
        part.method = draw.choice((DEFLATED, DEFLATED, STORED))
        part.packed = deflated(part.content, draw.randrange(10)) if part.method else None


@trick
def a_zip_file_among_the_files(one: Zip, draw: Random) -> None:
    """Honest: the manifest names it."""
    hidden = Part(b"certificates/1.zip", another_zip(one), draw.choice((STORED, DEFLATED)))
    one.parts.insert(draw.randrange(len(one.parts) + 1), hidden)
    restated(one)


@trick
def packed_again_by_another_program(one: Zip, draw: Random) -> None:
    """Honest, and not as the workbench packs."""
    ways = ("zipfile", "bsdtar", "bsdtar to a pipe", "7z", "7z, stored")
    way = draw.choice(ways)

    def change(_):
        return again({part.name.decode(): part.content for part in one.parts}, way)

    one.change.append(change)


def again(files: dict[str, bytes], way: str) -> bytes:
    """Files packed by another program."""
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder) / "files"
        for name, content in files.items():
            path = place / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
        out = Path(folder) / "out.zip"
        tops = sorted(one.name for one in place.iterdir())
        words = {
            "zipfile": ["python3", "-m", "zipfile", "-c", str(out), *tops],
            "bsdtar": ["bsdtar", "-c", "-a", "-f", str(out), *tops],
            "bsdtar to a pipe": ["bsdtar", "-c", "--format", "zip", "-f", "-", *tops],
            "7z": ["7z", "a", "-bd", str(out), *tops],
            "7z, stored": ["7z", "a", "-bd", "-mx=0", str(out), *tops],
        }[way]
        done = subprocess.run(words, cwd=place, capture_output=True, check=True)
        return out.read_bytes() if out.exists() else done.stdout
