"""What a bundle's zip file may say of its files: nothing hides in it, and nothing is obeyed."""

import ast
import tracemalloc
import zipfile
from collections import Counter

import pytest
from tampering import PUBLIC, Opened, verified

from workbench.extras.evidence import packing, verify


def test_what_a_terminal_obeys_is_printed_as_text(made, tmp_path):
    one = Opened(made / "bundle.zip")
    one.files["x\x1b[2J\nwhole, as it was signed"] = b""
    said = verified(made, one.packed(tmp_path / "bundle.zip"), "--key", PUBLIC)[1]
    assert "x\\x1b[2J\\nwhole" in said
    assert "\x1b" not in said


def test_nothing_in_the_script_takes_the_name_of_something_else(made):
    """It is put together from several files."""
    names: Counter[str] = Counter()
    for one in ast.parse((made / "verify.py").read_text()).body:
        if isinstance(one, (ast.FunctionDef, ast.ClassDef)):
            names[one.name] += 1
        for target in getattr(one, "targets", ()):
            names.update(node.id for node in ast.walk(target) if isinstance(node, ast.Name))
    assert names["blocks_of"] == 1 and set(names.values()) == {1}


def test_nothing_stands_beside_the_signature(made, tmp_path):
    """Nothing signs the file that it stands in."""
    one = Opened(made / "bundle.zip")
    one.files[packing.SIGNATURE] += b" " * 800 + b"it was all otherwise"
    code, said = verified(made, one.packed(tmp_path / "bundle.zip"), "--key", PUBLIC)
    assert (code, "the signature cannot be read" in said) == (1, True), said


@pytest.mark.parametrize("method", [zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED])
def test_the_same_files_packed_otherwise_are_not_the_bundle_that_was_signed(made, tmp_path, method):
    path = tmp_path / "bundle.zip"
    one = Opened(made / "bundle.zip")
    with zipfile.ZipFile(path, "w", method) as archive:
        for name, content in one.files.items():
            about = zipfile.ZipInfo(name)
            about.external_attr = 0o644 << 16
            archive.writestr(about, content, method)
    code, said = verified(made, path, "--key", PUBLIC)
    assert (code, "not packed as they were when they were signed" in said) == (1, True), said


def test_a_signature_that_is_larger_than_memory_is_not_unpacked(made, tmp_path):
    one = Opened(made / "bundle.zip")
    one.files[packing.SIGNATURE] += b" " * 2**24
    path = one.packed(tmp_path / "bundle.zip")
    tracemalloc.start()
    verify.problems_of(path, None, None)
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert most < 2**24
