"""Grasp files written: what comes back, what people wrote and is left alone, changes in words."""

import json
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st

from workbench.formats.parts.grasp_files import as_written, save_grasps
from workbench.formats.parts.grasp_words import changes_in_words
from workbench.formats.parts.reading import read_grasps, read_part
from workbench.formats.parts.saves import (
    DRAFT,
    draft_of,
    drop_draft,
    save_part,
    versions,
    write_draft,
)
from workbench.model.digest import digest_of
from workbench.model.errors import FileError
from workbench.model.geometry import pose_from_rpy
from workbench.model.part import Grasp, GraspLibrary, GraspPair, GraspPattern
from workbench.model.symmetry import Symmetry

NUMBERS = st.floats(-0.5, 0.5, allow_nan=False)
ANGLES = st.floats(-np.pi, np.pi, allow_nan=False)
NAMES = st.text("abcdefgh-_ ÄÖ漢'\"\\#", min_size=1, max_size=12).filter(str.strip)


@st.composite
def grasps(draw, name: str) -> Grasp:
    position = [draw(NUMBERS) for _ in range(3)]
    T = pose_from_rpy(position, [draw(ANGLES) for _ in range(3)])
    grip = draw(st.floats(0.0, 0.1))
    return Grasp(
        name,
        T,
        opening=grip + draw(st.floats(0.001, 0.1)),
        grip=grip,
        approach=draw(st.sampled_from([np.array([0.0, 0.0, 1.0]), np.array([0.0, 0.6, 0.8])])),
        approach_length=draw(st.floats(0.001, 0.9)),
        retreat=draw(st.sampled_from([None, np.array([0.0, 0.0, -1.0])])),
        priority=draw(st.integers(-9, 9)),
        is_enabled=draw(st.booleans()),
        arms=draw(st.sampled_from([(), ("left",), ("left", "right")])),
        free_rotation=draw(st.floats(0.0, np.pi - 1e-6)),
        tilt=draw(st.floats(0.0, 1.5)),
        slide=draw(st.floats(0.0, 0.9)),
    )


@st.composite
def libraries(draw) -> GraspLibrary:
    names = draw(st.lists(NAMES, max_size=4, unique=True))
    entries: list[Grasp | GraspPattern] = []
    for number, name in enumerate(names):
        grasp = draw(grasps(f"{number}{name}"))
        if draw(st.booleans()):
            lists = [tuple(draw(st.lists(NUMBERS, min_size=1, max_size=3))) for _ in range(3)]
            axis = np.array([0.0, 0.8, -0.6])
            pattern = GraspPattern(grasp, axis, lists[0], lists[1], across_offsets=lists[2])
            entries.append(pattern)
        else:
            entries.append(grasp)
    pairs = (GraspPair(entries[0].name, entries[-1].name, True),) if len(entries) > 1 else ()
    return GraspLibrary(tuple(entries), pairs)


@given(library=libraries())
def test_what_is_written_comes_back(library, tmp_path_factory):
    path = tmp_path_factory.mktemp("g") / "grasps.toml"
    save_grasps(path, library)
    back = read_grasps(path)
    assert digest_of(back) == digest_of(as_written(library))
    assert [entry.name for entry in back.entries] == [entry.name for entry in library.entries]
    for one, other in zip(back.grasps, library.grasps, strict=True):
        difference = one.T_part_tcp.actInv(other.T_part_tcp)
        assert np.abs(difference.translation).max() < 5e-6
        assert np.linalg.norm(pin.log3(difference.rotation)) < 1e-5
        assert one.opening == pytest.approx(other.opening, abs=1e-7)
        assert one.tilt == pytest.approx(other.tilt, abs=1e-6)
    before = path.read_bytes()
    save_grasps(path, back)
    assert path.read_bytes() == before, "saving once more changes nothing"


def test_tables_in_a_list_are_written_as_tables(tmp_path):
    path = tmp_path / "grasps.toml"
    line = (
        '{{name = "{}", position_mm = [0, 0, 30], points_along = [0, 0, -1], '
        "closes_along = [0, 1, 0], opening_mm = 40, grip_mm = 30}}"
    )
    path.write_text(
        f"grasp = [{line.format('a')}, {line.format('b')}]\n"
        'pair = [{first = "a", second = "b"}]\n'
    )
    library = read_grasps(path)
    moved = replace(library.entries[0], grip=0.02)
    for changed in (
        replace(library, entries=(moved, library.entries[1])),
        replace(library, entries=library.entries[:1], pairs=()),
        replace(library, pairs=(GraspPair("b", "a"),)),
    ):
        save_grasps(path, changed)
        again = read_grasps(path)
        assert [(one.name, one.grip) for one in again.entries] == [
            (one.name, one.grip) for one in changed.entries
        ]
        assert [(pair.first, pair.second) for pair in again.pairs] == [
            (pair.first, pair.second) for pair in changed.pairs
        ]
    assert "[[grasp]]" in path.read_text()


def test_comments_stay_and_only_what_differs_is_written(tmp_path):
    shipped = read_part("keyed_cylinder").library
    path = tmp_path / "grasps.toml"
    path.write_text(
        "# ours\n[[grasp]]\nname = 'a' # the best\nposition_mm = [1, 2, 3] # measured\n"
        "points_along = [0, 0, -1]\ncloses_along = [0, 1, 0]\nopening_mm = 20\ngrip_mm = 10\n"
        "\n# the other\n[[grasp]]\nname = 'b'\nposition_mm = [0, 0, 3]\n"
        "points_along = [0, 0, -1]\ncloses_along = [0, 1, 0]\nopening_mm = 20\ngrip_mm = 10\n"
    )
    old = read_grasps(path)
    a, b = old.entries
    save_grasps(path, GraspLibrary((replace(a, opening=0.025), b, shipped.entries[0])))
    text = path.read_text()
    for kept in ("# ours", "'a' # the best", "[1, 2, 3] # measured", "# the other"):
        assert kept in text
    assert "opening_mm = 25" in text
    assert text.count("[[grasp]]") == 3
    assert "[grasp.pattern]" in text


def test_a_grasp_file_that_is_broken_is_not_written_over(tmp_path):
    path = tmp_path / "grasps.toml"
    path.write_text("[[grasp]\n")
    with pytest.raises(FileError, match=r"grasps\.toml"):
        save_grasps(path, GraspLibrary())
    assert path.read_text() == "[[grasp]\n"


def test_changes_are_told_in_words():
    old = read_part("keyed_cylinder").library
    (side,) = old.entries
    T = side.grasp.T_part_tcp * pose_from_rpy((0.002, 0, 0), (0, 0, np.deg2rad(5)))
    moved = replace(
        side,
        grasp=replace(side.grasp, T_part_tcp=T, opening=0.044, is_enabled=False, arms=("left",)),
        offsets=side.offsets[:2],
    )
    other = replace(side.grasp, name="top")
    new = replace(old, entries=(moved, other), pairs=(GraspPair("side", "top", True),))
    assert tuple(map(str, changes_in_words(old, new))) == (
        "side: moved by 2.00 mm, turned by 5.00 deg, disabled, opening 40 → 44 mm, "
        "arms as usual → left, pattern changed, 15 → 10 grasps",
        "top is new, a grasp",
        "the pair side then top is new",
    )
    assert tuple(map(str, changes_in_words(new, old))) == (
        "top is gone",
        "side: moved by 2.00 mm, turned by 5.00 deg, enabled, opening 44 → 40 mm, "
        "arms left → as usual, pattern changed, 10 → 15 grasps",
        "the pair side then top is gone",
    )
    assert changes_in_words(old, old) == ()


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "part.toml").write_text("name = 'x' # ours\n")
    return tmp_path


def test_versions_are_kept_with_who_and_why(folder):
    part = read_part("keyed_cylinder")
    save_grasps(folder / "grasps.toml", part.library)
    side = part.library.entries[0]
    wider = replace(side, grasp=replace(side.grasp, opening=0.044))
    new = replace(part, library=replace(part.library, entries=(wider,)), symmetry=Symmetry(fold=3))
    write_draft(folder, new.library)
    assert digest_of(draft_of(folder)) == digest_of(as_written(new.library))
    save_part(folder, part, new, actor="ada", at=0.0, remark="wider")
    assert draft_of(folder) is None
    save_part(folder, new, part, actor="bob", at=60.0, remark="back")
    kept = versions(folder)
    assert [(v.number, v.by, v.remark) for v in kept] == [
        (1, "", "as it was before"),
        (2, "ada", "wider"),
        (3, "bob", "back"),
    ]
    assert kept[1].at == "1970-01-01T00:00:00Z"
    assert digest_of(kept[1].library) == digest_of(as_written(new.library))
    lines = [json.loads(line) for line in (folder / "changes.log").read_text().splitlines()]
    assert lines[1]["changes"] == ["side: opening 40 → 44 mm"]
    assert "# ours" in (folder / "part.toml").read_text()
    assert "fold = 1" in (folder / "part.toml").read_text()


def test_a_draft_that_says_what_is_saved_is_none(folder):
    part = read_part("keyed_cylinder")
    save_grasps(folder / "grasps.toml", part.library)
    side = part.library.entries[0]
    paired = replace(part.library, pairs=(GraspPair(side.name, side.name),))
    write_draft(folder, paired)
    assert len(draft_of(folder).pairs) == 1
    write_draft(folder, part.library)
    assert draft_of(folder) is None and not (folder / DRAFT).is_file()
    # An earlier version of the workbench has left such drafts.
    save_grasps(folder / DRAFT, part.library)
    assert draft_of(folder) is None


def test_broken_lines_of_the_log_are_passed_over(folder):
    part = read_part("keyed_cylinder")
    save_part(folder, replace(part, library=GraspLibrary()), part, actor="a", at=0, remark="r")
    with (folder / "changes.log").open("a") as log:
        log.write('{"version": 1\nno json\n{"version": 99, "at": "", "by": "", "remark": ""}\n')
    assert [v.number for v in versions(folder)] == [1, 2]
    drop_draft(folder)  # one that is not there
