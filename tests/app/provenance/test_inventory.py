"""What runs is named by a digest, and what differs between two starts is said."""

from dataclasses import replace

import pytest

from workbench.app.provenance.gathering import files_digest, find_installed, inventory, processor
from workbench.app.provenance.inventory import Distribution, Inventory, differences
from workbench.app.records.forms import restore_value
from workbench.model.digest import canonical

NUMPY = Distribution("numpy", "2.1.0", "a" * 64)

BEFORE = Inventory(
    workbench="0.1.0",
    files="f" * 64,
    python="CPython 3.11.7",
    processor="some processor avx2 fma",
    system="Linux 6.1 glibc 2.36",
    distributions=(NUMPY, Distribution("scipy", "1.14.0", "b" * 64)),
    cell="yumi",
    cell_digest="c" * 64,
    parts={"peg": "1" * 64},
    calibration="d" * 64,
    users={"Anna": "engineer"},
)


@pytest.mark.parametrize(
    ("changed", "says"),
    [
        ({"workbench": "0.2.0", "files": "0" * 64}, "workbench 0.1.0 is now 0.2.0"),
        ({"files": "0" * 64}, "the files of workbench 0.1.0 were changed"),
        (
            {"distributions": (replace(NUMPY, version="2.2.0"), BEFORE.distributions[1])},
            "numpy 2.1.0 is now 2.2.0",
        ),
        (
            {"distributions": (replace(NUMPY, record="0" * 64), BEFORE.distributions[1])},
            "the files of numpy 2.1.0 were changed",
        ),
        ({"distributions": (NUMPY,)}, "scipy 1.14.0 was removed"),
        (
            {"distributions": (*BEFORE.distributions, Distribution("zlib", "1.3", ""))},
            "zlib 1.3 was added",
        ),
        ({"python": "CPython 3.12.1"}, "python CPython 3.11.7 is now CPython 3.12.1"),
        ({"processor": "other"}, "processor some processor avx2 fma is now other"),
        ({"system": "Linux 6.2 glibc 2.36"}, "system Linux 6.1 glibc 2.36 is now Linux 6.2 glibc"),
        (
            {"parts": {"peg": "2" * 64}, "cell_digest": "0" * 64},
            "parts of the cell were changed: peg",
        ),
        ({"calibration": "0" * 64, "cell_digest": "0" * 64}, "the scanner's pose was changed"),
        ({"cell_digest": "0" * 64}, "the cell was changed"),
        ({"users": {"Anna": "viewer"}}, "user Anna is viewer now, was engineer"),
        ({"users": {}}, "user Anna (engineer) was removed"),
        ({"users": {"Anna": "engineer", "Eve": "viewer"}}, "new user Eve (viewer)"),
    ],
)
def test_each_change_is_one_phrase_and_another_digest(changed, says):
    after = replace(BEFORE, **changed)
    (said,) = differences(BEFORE, after)
    assert str(said).startswith(says)
    assert after.digest != BEFORE.digest


def test_nothing_is_said_where_nothing_differs():
    assert differences(BEFORE, replace(BEFORE)) == ()
    assert replace(BEFORE).digest == BEFORE.digest


def test_an_inventory_comes_back_from_its_record():
    again = restore_value(Inventory, canonical(BEFORE), lambda digest: b"")
    assert again.digest == BEFORE.digest
    assert again.distributions[0].record == "a" * 64


def test_what_runs_here_is_read_from_the_machine(cell):
    one = inventory(cell, {"Anna": "engineer"})
    names = [each.name for each in one.distributions]
    assert names == sorted(set(names))
    assert {"numpy", "viser", "trimesh"} <= set(names)
    assert one.parts.keys() == {part.name for part in cell.parts}
    assert one.python.startswith("CPython 3.")
    assert inventory(cell, {"Anna": "engineer"}).digest == one.digest


def test_every_distribution_is_told_by_what_its_files_are():
    numpy = next(one for one in find_installed() if one.name == "numpy")
    assert len(numpy.record) == 64


def test_one_byte_in_one_file_of_ours_is_another_digest(tmp_path):
    package = tmp_path / "workbench"
    package.mkdir()
    (package / "a.py").write_text("one = 1\n")
    (tmp_path / "static").mkdir()
    (tmp_path / "static" / "page.css").write_text("")
    digests = {files_digest(package)}
    (package / "a.nbi").write_text("compiled")
    assert files_digest(package) in digests
    for path, text in ((package / "a.py", "one = 2\n"), (tmp_path / "static" / "page.css", "x")):
        path.write_text(text)
        digests.add(files_digest(package))
    (package / "a.py").rename(package / "b.py")
    digests.add(files_digest(package))
    assert len(digests) == 4


def test_a_processor_is_its_model_with_what_libraries_choose_by(tmp_path):
    file = tmp_path / "cpuinfo"
    file.write_text("model name\t: Some CPU\nflags\t: fpu avx2 sse fma\n\nmodel name\t: Some CPU\n")
    assert processor(file) == "Some CPU avx2 fma"
    assert processor(tmp_path / "none")
