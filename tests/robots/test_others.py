"""The table of robots as others describe them: read and found, or refused with what to do."""

import importlib
import sys
import sysconfig
from pathlib import Path

import pytest

SHARE = Path(sysconfig.get_path("purelib")) / "cmeel.prefix/share/example-robot-data/robots"

pytestmark = pytest.mark.skipif(not SHARE.is_dir(), reason="example-robot-data is not installed")


@pytest.fixture(scope="module")
def table():
    docs = str(Path(__file__).resolve().parents[2] / "docs")
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(docs)
        yield importlib.import_module("make_robots")
        sys.modules.pop("make_robots")


@pytest.mark.parametrize(
    ("file", "says"),
    [
        # Mirrored meshes on one side.
        ("tiago_description/robots/tiago_dual.urdf", None),
        ("talos_data/robots/talos_reduced_box.urdf", None),
        # A foot whose picture is missing in its DAE file.
        ("anymal_b_simple_description/robots/anymal.urdf", "to be named: robot anymal"),
        # Legs of two joints, some of which have no range.
        ("quadruped_description/urdf/quadruped.urdf", "to be named: robot quadroped"),
        # Joints without a speed.
        ("romeo_description/urdf/romeo.urdf", None),
    ],
)
def test_what_is_in_the_table_is_so(table, file, says):
    links, arms = table.found(SHARE / file)
    if says is None:
        assert "refused" not in arms, arms
        assert int(links) > 20
    else:
        assert says in arms


def test_a_line_for_each_file(table, tmp_path):
    (tmp_path / "one | two.urdf").write_text("<robot name='one'></robot>")
    lines = list(table.rows([tmp_path], []))
    assert lines[0].startswith("| file |") and len(lines) == 3
    assert lines[2] == "| `one / two.urdf` |  | refused: has no links |"
