"""The study of localization: what its table says follows from its scenes."""

import json

import numpy as np
import pinocchio as pin
import pytest

from workbench.cli.main import main
from workbench.formats.parts.reading import read_part
from workbench.model.geometry import pose_from_rpy
from workbench.model.scan import Detection
from workbench.studies.localization import (
    Found,
    Scene,
    Task,
    compare,
    localized_scene,
    summary,
)

TASK = Task("yumi", "bolt", "fine", 2, 0)
RIGHT = Found(0.0001, 0.001, True, True)
WRONG = Found(0.004, 0.1, True, False)


def turned(T: pin.SE3, degrees: float) -> pin.SE3:
    return T * pose_from_rpy((0, 0, 0), (0, 0, np.deg2rad(degrees)))


def test_rows_count_what_the_scenes_hold():
    scenes = [
        Scene(
            TASK,
            (RIGHT, RIGHT, WRONG),
            (0.9, 0.8, 0.5),
            (True, True, False),
            0.3,
            processor_seconds=0.1,
        ),
        Scene(TASK, (WRONG,), (0.7, 0.59, 0.2), (False, False, False), 0.5, processor_seconds=0.3),
    ]
    (row,) = summary(scenes)
    assert (row["part"], row["build"], row["count"], row["scenes"]) == ("bolt", "fine", 2, 2)
    assert (row["parts"], row["clear"], row["found"], row["missed"]) == (6, 3, 4, 1)
    assert row["best_right"] == pytest.approx(2 / 3)
    assert row["precision"] == pytest.approx(2 / 4)
    assert row["recall"] == pytest.approx(2 / 3)
    assert row["seconds"]["median"] == pytest.approx(0.4)
    assert row["processor_seconds"]["worst"] == pytest.approx(0.3)


def test_nothing_found_gives_no_shares():
    (row,) = summary([Scene(TASK, (), (0.3,), (False,), 0.1)])
    assert row["precision"] is row["best_right"] is row["recall"] is row["distance"] is None


def test_each_part_build_and_count_has_a_row_of_its_own():
    tasks = [Task("yumi", p, b, c, 0) for p in ("a", "b") for b in ("x", "y") for c in (2, 8)]
    rows = summary([Scene(task, (RIGHT,), (1.0,), (True,), 0.1) for task in tasks])
    assert [(r["part"], r["build"], r["count"]) for r in rows] == [
        (t.part, t.build, t.count) for t in tasks
    ]


@pytest.mark.parametrize(
    ("degrees", "known", "is_right"),
    [(0, True, True), (60, True, True), (30, True, False), (30, False, True), (2, True, True)],
)
def test_a_hexagon_may_be_turned_by_sixths_and_an_unknown_roll_claims_nothing(
    degrees, known, is_right
):
    bolt, T = read_part("bolt"), pose_from_rpy((0.4, 0, 0.02), (1.3, 0.2, 0.5))
    found, is_found = compare(
        (bolt,), (Detection("bolt", T),), (Detection("bolt", turned(T, degrees), roll_known=known),)
    )
    assert (found[0].is_right, is_found) == (is_right, (is_right,))


def test_limits_are_two_millimetres_and_three_degrees():
    part, T = read_part("bracket"), pose_from_rpy((0.4, 0, 0.02))
    for off, is_right in ((0.0019, True), (0.0021, False)):
        moved = pin.SE3(T.rotation, T.translation + [off, 0, 0])
        assert (
            compare((part,), (Detection("bracket", T),), (Detection("bracket", moved),))[0][
                0
            ].is_right
            is is_right
        )


def test_one_true_part_is_found_once():
    part, T = read_part("bracket"), pose_from_rpy((0.4, 0, 0.02))
    found, is_found = compare(
        (part,), (Detection("bracket", T),), (Detection("bracket", T), Detection("bracket", T))
    )
    assert [one.is_right for one in found] == [True, False]
    assert is_found == (True,)


@pytest.mark.parametrize("part", ["bolt", "bracket"])
def test_a_scene_is_the_same_again_and_its_parts_are_found(part):
    task = Task("yumi", part, "fine", 2, 5)
    first, again = localized_scene(task), localized_scene(task)
    assert (first.found, first.visible) == (again.found, again.visible)
    assert all(one.is_right for one in first.found)
    assert first.is_found == (True, True)
    assert first.processor_seconds > 0.0


def test_a_scanner_that_is_off_moves_the_truth_with_what_it_sees():
    task = Task("yumi", "bracket", "fine", 2, 5, raised=0.005, tilted=float(np.deg2rad(1.0)))
    scene = localized_scene(task)
    assert scene.is_found == (True, True)
    assert all(one.is_right for one in scene.found)


def test_what_is_found_of_another_kind_is_wrong():
    scene = localized_scene(Task("yumi", "bracket", "fine", 1, 5, searched="bolt"))
    assert (scene.visible, scene.is_found) == ((), ())
    assert not any(one.is_right for one in scene.found)


def test_an_empty_bin_is_a_task_too():
    scene = localized_scene(Task("yumi", "bolt", "fine", 0, 5, raised=-0.004))
    assert (scene.found, scene.visible) == ((), ())


def test_a_cad_file_of_another_size_is_said_to_be_one():
    (size,) = localized_scene(Task("yumi", "bracket", "fine", 5, 100, cad_scale=0.98)).scales
    assert str(size.words) == "the CAD file of bracket seems 2.0% too small for the scan"


def test_figures_are_those_of_bop_too(capsys):
    arguments = ["--parts", "bracket", "--counts", "2", "--noise", "fine", "--scenes", "1"]
    assert main(["study", "localization", *arguments, "--seed", "5", "--json"]) == 0
    (row,) = json.loads(capsys.readouterr().out)["rows"]
    assert row["bop"]["mssd"] == row["bop"]["mssd_mm"] == row["bop"]["mspd"] == 1.0
    assert row["bop"]["objects"]["bracket"]["targets"] == 2
    # Two parts are not enough to tell a size.
    assert row["size"] == {"told": 0, "said": 0, "median": None}
    assert main(["study", "localization", *arguments, "--cad-scale", "3"]) == 2
    assert "--cad-scale" in capsys.readouterr().err
