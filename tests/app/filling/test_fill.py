"""Libraries filled: what is made holds the part and takes what lies in piles."""

import weakref
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
import trimesh

from workbench.app.filling import clearing, fill
from workbench.app.filling.fill import filled
from workbench.app.filling.words import filled_words
from workbench.formats.cells.reading import read_cell
from workbench.formats.parts.grasp_files import as_written, keys_of
from workbench.formats.parts.reading import read_part
from workbench.model.errors import InputError, JobCancelled
from workbench.model.geometry import Mesh, Solid
from workbench.model.part import GraspLibrary, Part
from workbench.model.symmetry import Symmetry
from workbench.planning.grasps.grasp_check import GraspChecker

WORK = 12_000.0


def part_of(body: trimesh.Trimesh, symmetry: Symmetry | None = None) -> Part:
    """A part of one convex piece, in mm, without grasps."""
    mesh = Mesh(np.asarray(body.vertices) / 1000, np.asarray(body.faces))
    pieces = (Solid("body", mesh, pin.SE3.Identity()),)
    return Part("made", mesh, pieces, 0.05, symmetry or Symmetry(), GraspLibrary())


@pytest.fixture(scope="module")
def yumi():
    return read_cell("yumi")


@pytest.fixture(scope="module")
def rod():
    body = trimesh.creation.cylinder(6, 60, sections=48)
    return part_of(body, Symmetry(np.array([0.0, 0.0, 1.0]), 0))


@pytest.fixture(scope="module")
def filling(yumi, rod):
    return filled(yumi, rod, most=WORK)


def test_every_grasp_of_a_filled_library_holds_the_part(yumi, rod, filling):
    checker = GraspChecker(rod, yumi.arms[0].tool)
    grasps = GraspLibrary(filling.entries).grasps
    assert grasps and all(checker.check(grasp).is_ok for grasp in grasps)


def test_a_filled_library_takes_most_of_what_lies_in_its_piles(filling):
    assert filling.parts >= 4 and filling.taken >= 0.7 * filling.parts
    assert str(filled_words(filling)[0]).startswith(f"{filling.taken} of {filling.parts} parts")


def test_families_come_in_the_order_of_what_they_are_looked_at(filling):
    entries = GraspLibrary(filling.entries).grasps
    priorities = [grasp.priority for grasp in entries]
    assert priorities[0] == -1 and priorities == sorted(priorities, reverse=True)
    assert len({entry.name for entry in filling.entries}) == len(filling.entries)


def test_a_filled_library_can_be_written_and_read(filling):
    back = as_written(GraspLibrary(filling.entries))
    assert [one.name for one in back.grasps] == [
        one.name for one in GraspLibrary(filling.entries).grasps
    ]


def test_what_a_library_takes_already_is_not_added_again(yumi):
    part = read_part("parts/keyed_cylinder/full_bin")
    found = filled(yumi, part, most=WORK)
    assert not {entry.name for entry in found.entries} & {e.name for e in part.library.entries}
    alone = filled(yumi, replace(part, library=GraspLibrary()), most=WORK)
    assert sum(found.adds) < sum(alone.adds)


def test_a_cup_is_given_its_faces(rod):
    found = filled(read_cell("tx2_90"), part_of(trimesh.creation.box((50, 40, 20))), most=WORK)
    assert found.entries and all(entry.name.startswith(("face", "end")) for entry in found.entries)


def test_a_slower_machine_fills_the_same_library(yumi, rod, filling, monkeypatch):
    monkeypatch.setattr(fill, "processor_time", iter(range(0, 100_000, 1000)).__next__)
    slow = filled(yumi, rod, most=WORK)
    assert slow.seconds > 100 and _keys(slow) == _keys(filling)
    assert (slow.taken, slow.parts) == (filling.taken, filling.parts)


def _keys(found):
    return [keys_of(entry) for entry in found.entries]


def test_piles_that_were_emptied_leave_no_world_behind(yumi, rod, monkeypatch):
    alive, most = weakref.WeakSet(), []

    class Counted(clearing.World):
        def __init__(self, *arguments):
            super().__init__(*arguments)
            alive.add(self)
            most.append(len(alive))

    monkeypatch.setattr(clearing, "World", Counted)
    filled(yumi, rod, most=WORK)
    assert len(most) > 3 and max(most) <= 2


def test_filling_ends_when_it_is_cancelled(yumi, rod):
    with pytest.raises(JobCancelled):
        filled(yumi, rod, cancelled=lambda: True)


def test_a_part_larger_than_the_bin_is_refused_in_one_sentence(yumi):
    with pytest.raises(
        InputError,
        match="part made of 500 x 20 x 20 mm is too large for the bin of 200 x 300 x 50 mm",
    ):
        filled(yumi, part_of(trimesh.creation.box((500, 20, 20))))


def test_a_mesh_inside_out_is_refused_with_what_turns_it(yumi):
    body = trimesh.creation.cylinder(6, 60, sections=24)
    body.invert()
    with pytest.raises(InputError, match="part made is inside out; `workbench part import`"):
        filled(yumi, part_of(body))


def test_a_part_of_a_few_milligrams_is_filled_as_any_other(yumi, rod, filling):
    light = filled(yumi, replace(rod, mass=5e-6), most=WORK)
    assert light.entries and light.taken >= 0.7 * light.parts


def test_a_tool_without_opening_is_refused_with_its_opening(yumi, rod):
    shut = tuple(replace(arm, tool=replace(arm.tool, stroke=(0.0, 0.0))) for arm in yumi.arms)
    with pytest.raises(InputError, match=r"smart_gripper opens 0\.0 mm to 0\.0 mm"):
        filled(replace(yumi, arms=shut), rod)
