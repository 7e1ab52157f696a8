"""Zip files made to mean two things: what is accepted unpacks alike with every program."""

import re
import runpy
import shutil
import struct
from collections import Counter
from contextlib import suppress
from pathlib import Path
from random import Random

import pytest
import zip_content_tricks  # noqa: F401 - adds to TRICKS, as those below do
import zip_name_tricks  # noqa: F401
import zip_other_forms  # noqa: F401
from tampering import ENDS, OURS, PUBLIC, Opened
from zip_forging import STORED, TRICKS, Part, Zip
from zip_tools import needs_tools, tree_of, unpacked

from workbench.extras.evidence import packing, verify
from workbench.formats.files.archives import unpack
from workbench.model.errors import FileError

EACH, COMBINED = 10, 60
CLASSES = [*TRICKS, "several of these at once"]
KEY = bytes.fromhex(PUBLIC)

TABLE = Path(__file__).with_name("forged_zips.md")
ROW = re.compile(r"^\| ([a-z0-9 ]+) \| (\d+) \| (\d+) \| (\d+) \| (\d+) \| (\d+) \|$", re.MULTILINE)
SAID = {row[0]: tuple(map(int, row[1:])) for row in ROW.findall(TABLE.read_text("utf-8"))}
"""By class: made; refused and accepted by `verify.py`; accepted by what restores and imports; and
from how many the programs unpack different files, which is a matter of their versions."""

HONEST = {
    "another order and level",
    "a zip file among the files",
    "packed again by another program",
}


def begun(path):
    """A bundle, as if its session had just begun then."""
    one = Opened(path)
    one.sql("DELETE FROM entries WHERE number > 2; UPDATE sqlite_sequence SET seq = 2;")
    one.sql("DELETE FROM entry_files; VACUUM;")
    left_out = (verify.FILES, "certificates", "report.pdf")
    one.files = {k: v for k, v in one.files.items() if not k.startswith(left_out)}
    one.made_good()
    return one


@pytest.fixture(scope="session")
def older():
    """Files of a bundle of workbench 0.2.0: the manifest does not say how they are packed."""
    one = begun(Path(__file__).with_name("of_0_2_0.zip"))
    one.as_of_0_2_0()
    return one.files


@pytest.fixture(scope="session")
def newer(made):
    """Files of a bundle as it is now."""
    one = begun(made / "bundle.zip")
    one.signed(OURS)
    return one.files


@pytest.fixture(scope="session")
def problems_of(made):
    """Of the script in a bundle: what is wrong with another one."""
    of = runpy.run_path(str(made / "verify.py"))["problems_of"]
    return lambda path: of(path, KEY, None)[0]


def as_packed(files):
    """A zip file as the workbench packs it: now it stores what it writes last."""
    one = Zip([Part(key.encode(), content) for key, content in files.items()])
    for end in ENDS if b'"packed"' in files[packing.MANIFEST] else ():
        one.part(end.encode()).method = STORED
    return one


def forged(files, name, number):
    """A zip file of a class, its bytes, and how it was made."""
    draw = Random(f"{name} {number}")
    while True:
        one = as_packed(files)
        names = [name] if name in TRICKS else draw.sample(list(TRICKS), draw.randrange(2, 5))
        # Of several tricks one may take away what another one changes.
        with suppress(struct.error, StopIteration, IndexError, UnicodeError):
            for each in names:
                TRICKS[each](one, draw)
            return one, one.made(), names


def contents(path):
    with path.open("rb") as file:
        bundle = packing.PackedFiles(file)
        return {name: b"".join(bundle.blocks(name)) for name in bundle.members}


@needs_tools
@pytest.mark.parametrize("name", CLASSES)
def test_what_is_accepted_unpacks_alike_with_every_program(problems_of, older, tmp_path, name):
    counts = Counter(made=EACH if name in TRICKS else COMBINED)
    path, out, tools = tmp_path / "x.zip", tmp_path / "out", tmp_path / "tools"
    for number in range(counts["made"]):
        _, content, names = forged(older, name, number)
        path.write_bytes(content)
        found = unpacked(path, tools)
        trees = [tree for _, tree in found.values()]
        counts["differ"] += any(tree != trees[0] for tree in trees)
        taken: list[dict] = []
        if problems_of(path):
            counts["refused"] += 1
        else:
            taken.append(contents(path))
        with suppress(FileError):
            unpack(path, out)
            taken.append(tree_of(out, out))
            counts["unpacked"] += 1
        for one in taken:
            wrong = [program for program, told in found.items() if told != (True, one)]
            assert not wrong, (number, names)
        for folder in (out, tools):
            shutil.rmtree(folder, ignore_errors=True)
    counts["accepted"] = counts["made"] - counts["refused"]
    row = [counts[key] for key in ("made", "refused", "accepted", "unpacked", "differ")]
    said = f"| {name} | {' | '.join(map(str, row))} |"
    print(said)
    assert SAID.get(name, ())[:3] == tuple(row[:3]), f"{TABLE.name} lacks {said}"
    assert counts["unpacked"] == EACH or name not in HONEST


def test_the_document_tells_of_each_class_once():
    assert list(SAID) == CLASSES
    assert sum(made for made, *_ in SAID.values()) == EACH * len(TRICKS) + COMBINED


@needs_tools
@pytest.mark.parametrize("name", TRICKS)
def test_a_bundle_of_now_can_be_packed_in_no_other_way(problems_of, newer, tmp_path, name):
    path, untouched = tmp_path / "x.zip", as_packed(newer).made()
    path.write_bytes(untouched)
    assert problems_of(path) == []
    for number in range(EACH):
        one, content, _ = forged(newer, name, number)
        path.write_bytes(content)
        # What was signed anew, with the right key, is a bundle as before.
        is_signed_anew = one.part(b"manifest.sig").content != newer[packing.SIGNATURE]
        if content != untouched and not is_signed_anew:
            assert problems_of(path), number
