"""Regions of interest: the compartments of the page "A new robot in an hour"."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from judge import Judge
from judge_files import read

from workbench.app.picking.glance import glance_at
from workbench.app.picking.pipeline import plan_pick
from workbench.formats.cells.differences import difference
from workbench.formats.cells.edits import save_cell
from workbench.formats.cells.reading import read_cell
from workbench.formats.files.shipped import find
from workbench.gui.scene.stations import edges_of
from workbench.gui.shared.movable_frames import move_frame, pose_of, things
from workbench.model.candidate import Reason
from workbench.model.errors import FileError
from workbench.model.geometry import pose_from_rpy
from workbench.model.part import Region
from workbench.model.scan import Detection
from workbench.perception.localization.kinds import localize_parts
from workbench.perception.scene.unexplained import unexplained
from workbench.perception.simulation.synthesize import synthesize
from workbench.planning.collision.world import World
from workbench.plugins.progress import never, silent
from workbench.proof.claims.prove import prove

SHIPPED = find("robots", "yumi")
PAGE = SHIPPED.parents[1] / "docs" / "new_robot.md"


def written(folder: Path, more: str) -> Path:
    """The folder of the shipped cell with more in its file."""
    folder.mkdir()
    for one in SHIPPED.iterdir():
        if one.suffix != ".toml":
            (folder / one.name).symlink_to(one)
    text = (SHIPPED / "cell.toml").read_text(encoding="utf-8")
    (folder / "cell.toml").write_text(f"{text}\n{more}", encoding="utf-8")
    return folder


@pytest.fixture
def folder(tmp_path):
    (block,) = [
        one
        for one in re.findall(r"```toml\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
        if "[[bin.region]]" in one
    ]
    return written(tmp_path / "compartments", block)


def lying(cell, x, y):
    """A cylinder flat on the floor, along x."""
    T = cell.bin.T_world_bin * pose_from_rpy((x, y, 0.019), (0, np.pi / 2, 0))
    return Detection("keyed_cylinder", T)


def only(cell, name):
    """The cell with one of its regions."""
    regions = tuple(one for one in cell.bin.regions if one.name == name)
    return replace(cell, bin=replace(cell.bin, regions=regions))


@pytest.mark.extensive
def test_both_compartments_of_the_page_are_picked_from_beside_their_divider(folder):
    cell, files = read_cell(folder), read(folder, PAGE.parents[1] / "parts")
    assert [one.name for one in cell.bin.regions] == ["left", "right"]
    truth = (lying(cell, 0.0, 0.08), lying(cell, 0.02, -0.07))
    scan = synthesize(cell, truth, seed=4)
    found = localize_parts(
        scan, cell, seed=4, detail=1.0, report=silent, cancelled=never
    ).result.detections
    off = [
        min(np.linalg.norm(a.T_world_part.translation - b.T_world_part.translation) for b in truth)
        for a in found
    ]
    assert len(found) == 2 and max(off) < 0.001
    plan = plan_pick(
        cell, found, scan.digest, obstacles=unexplained(cell, scan, found), seed=4
    ).plan
    assert plan is not None and prove(cell, plan.scene, plan).holds
    assert Judge().refusal(files, plan.scene, plan) is None


def test_what_lies_outside_is_no_candidate_and_a_plan_that_takes_it_does_not_hold(folder):
    cell = read_cell(folder)
    left, right = only(cell, "left"), only(cell, "right")
    pile = (lying(cell, 0.0, 0.08), lying(cell, 0.02, -0.07))
    result = plan_pick(left, pile, "scan", seed=4)
    outside = Reason.OUTSIDE_REGIONS
    assert {one.verdict.reason for one in result.candidates if one.detection == 1} == {outside}
    assert outside not in {one.verdict.reason for one in result.candidates if one.detection == 0}
    assert result.plan is not None
    assert [one.detection for one in result.plan.arms] == [0]
    plan = replace(result.plan, cell_digest=right.digest)
    told = [str(one.problem) for one in prove(right, plan.scene, plan).violations]
    assert "the part lies outside the regions of interest" in told
    files = read(folder, PAGE.parents[1] / "parts")
    files.cell["bin"]["region"] = [
        one for one in files.cell["bin"]["region"] if one["name"] == "right"
    ]
    refusal = Judge().refusal(files, plan.scene, plan)
    assert refusal is not None and refusal.why == "takes a part outside of the regions"
    glance = glance_at(World(left, pile))
    said = {reason for one, reason in zip(glance.detections, glance.reasons, strict=True) if one}
    assert said == {outside}


def test_far_from_the_regions_nothing_is_searched_and_the_cloud_is_an_obstacle(folder):
    cell = read_cell(folder)
    small = replace(cell.bin.regions[0], size=np.array([0.2, 0.03, 0.1]))
    at = pose_from_rpy((0.0, 0.13, 0.0))
    cell = replace(cell, bin=replace(cell.bin, regions=(replace(small, T_bin_region=at),)))
    truth = (lying(cell, 0.0, 0.128), lying(cell, 0.0, -0.12))
    scan = synthesize(cell, truth, seed=5)
    (found,) = localize_parts(
        scan, cell, seed=5, detail=1.0, report=silent, cancelled=never
    ).result.detections
    assert np.linalg.norm(found.T_world_part.translation - truth[0].T_world_part.translation) < 1e-3
    boxes = unexplained(cell, scan, (found,))
    away = [
        np.abs(one.T_world_box.actInv(truth[1].T_world_part).translation) - one.size / 2
        for one in boxes
    ]
    assert min(one.max() for one in away) <= 0.0


def test_a_part_that_stands_on_a_station_is_taken_from_there(folder):
    cell = only(read_cell(folder), "left")
    (one,) = (lying(cell, 0.02, -0.07),)
    put = replace(one, T_world_found=lying(cell, 0.0, 0.08).T_world_part)
    reasons = {one.verdict.reason for one in plan_pick(cell, (put,), "scan", seed=4).candidates}
    assert Reason.OUTSIDE_REGIONS not in reasons


@pytest.mark.parametrize(
    ("more", "problem"),
    [
        ('[[bin.region]]\nname = "a"\nposition_mm = [0, 400, 0]\nsize_mm = [9, 9, 9]', "'a' lies"),
        ('[[bin.region]]\nname = "a"\nsize_mm = [9, 9]', "bin.region"),
        ("[[bin.region]]\nsize_mm = [9, 9, 9]", "name"),
        ('[[bin.region]]\nname = "a"\nsize_mm = [9, 9, 9]\n' * 2, "'a' is there 2 times"),
        ('[[bin.region]]\nname = "a"\nsize_mm = [9, 9, 9]\nof = "bin"', "of"),
    ],
)
def test_what_is_wrong_with_a_region_is_told(more, problem, tmp_path):
    with pytest.raises(FileError, match=problem):
        read_cell(written(tmp_path / "cell", more))


def test_a_region_is_a_thing_that_is_moved_and_saved_and_the_bin_takes_it_along(folder):
    cell = read_cell(folder)
    assert things(cell)[:3] == ("bin", "region left", "region right")
    T = pose_of(cell, "region left") * pose_from_rpy((0.0, 0.01, 0.0), (0, 0, 0.1))
    other = move_frame(cell, "region left", T)
    assert pose_of(other, "region left").isApprox(T, 1e-9)
    assert pose_of(other, "region right") == pose_of(cell, "region right")
    assert str(difference(cell, other)) == "the regions of interest were changed"
    save_cell(folder / "cell.toml", other)
    again = read_cell(folder)
    assert pose_of(again, "region left").isApprox(T, 1e-5)
    assert "position_mm = [0, 86, 0]" in (folder / "cell.toml").read_text(encoding="utf-8")
    step = pose_from_rpy((0.02, 0.0, 0.0))
    further = move_frame(again, "bin", step * again.bin.T_world_bin)
    assert pose_of(further, "region left").isApprox(step * pose_of(again, "region left"), 1e-9)


def test_regions_can_neither_be_added_nor_taken_away_by_saving(folder):
    cell = read_cell(folder)
    with pytest.raises(FileError, match="cannot be written"):
        save_cell(folder / "cell.toml", only(cell, "left"))


def test_a_region_is_drawn_by_its_edges():
    lines = edges_of(Region("a", pose_from_rpy((0, 0, 0)), np.array([0.2, 0.1, 0.3])))
    lengths = sorted(np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1).round(6).tolist())
    assert lengths == [0.1] * 4 + [0.2] * 4 + [0.3] * 4
    assert lines[..., 2].min() == 0.0
