"""Clouds in the unit that the cell's scanner has: every command that reads one goes by it."""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import open3d as o3d
import pytest
from shipped import shipped

from workbench.formats.cells.reading import cell_path
from workbench.formats.clouds.scans import read_cloud
from workbench.formats.plans.plan_files import read_plan
from workbench.formats.plans.pose_files import read_poses

PER_METRE = {"mm": 1000.0, "inch": 1 / 0.0254, "m": 1.0}
CELL = shipped("yumi")


@dataclass(frozen=True)
class Foreign:
    """A cell whose scanner has another unit, and a scan in it that another program has written."""

    cell: Path
    scan: Path


def cell_in(unit: str, folder: Path) -> Path:
    """The shipped YuMi with a scanner whose files are in `unit`."""
    shipped = cell_path("yumi")
    text = shipped.read_text().replace("[scanner]\n", f'[scanner]\nunit = "{unit}"\n')
    assert f'unit = "{unit}"' in text
    home = folder / "cells" / "yumi"
    home.mkdir(parents=True)
    for beside in shipped.parent.iterdir():
        if beside.name != "cell.toml":
            (home / beside.name).symlink_to(beside)
    (home / "cell.toml").write_text(text)
    return home / "cell.toml"


@pytest.fixture(params=[("mm", ".ply"), ("mm", ".pcd"), ("inch", ".ply")], ids="".join)
def foreign(line, tmp_path, request) -> Foreign:
    unit, kind = request.param
    scan = read_cloud(line.scan, CELL.scanner.T_world_scanner)
    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(scan.points * PER_METRE[unit]))
    assert o3d.io.write_point_cloud(str(tmp_path / f"scan{kind}"), cloud)
    return Foreign(cell_in(unit, tmp_path), tmp_path / f"scan{kind}")


def test_localize_finds_the_parts_where_they_are(foreign, line, say, tmp_path):
    out = tmp_path / "poses.json"
    said = say("localize", foreign.cell, "--scan", foreign.scan, "--out", out)
    assert said.code == 0, said.err
    found, truth = (read_poses(path, "keyed_cylinder") for path in (out, line.truth))
    assert len(found) == len(truth)
    for one in found:
        p = one.T_world_part.translation
        assert min(np.linalg.norm(p - other.T_world_part.translation) for other in truth) < 0.001


def test_plan_and_explain_see_the_obstacle_where_it_is(foreign, line, say, tmp_path):
    poses, out = tmp_path / "one.json", tmp_path / "plan.json"
    content = json.loads(line.poses.read_text())
    missed = read_poses(line.poses, "keyed_cylinder")[1].T_world_part.translation
    content["detections"] = content["detections"][:1]
    poses.write_text(json.dumps(content))
    asked = ("--poses", poses, "--scan", foreign.scan)
    said = say("plan", foreign.cell, *asked, "--out", out)
    assert said.code == 0, said.err
    boxes = read_plan(out)[0].obstacles
    assert min(np.linalg.norm(box.T_world_box.translation - missed) for box in boxes) < 0.06
    said = say("explain", foreign.cell, *asked)
    assert said.code == 0, said.err


def test_a_scan_written_for_a_cell_is_in_its_unit_and_is_read_there(say, tmp_path):
    cell, scan, poses = cell_in("mm", tmp_path), tmp_path / "scan.ply", tmp_path / "poses.json"
    said = say("scan", cell, "--out", scan, "--seed", 1)
    assert said.code == 0, said.err
    points = read_cloud(scan, CELL.scanner.T_world_scanner, unit="mm").points
    assert 0.5 < np.median(points[:, 2]) < 1.3
    said = say("localize", cell, "--scan", scan, "--out", poses)
    assert said.code == 0, said.err
    assert len(read_poses(poses, "keyed_cylinder")) == 2


def test_calibrate_goes_by_the_cell_where_the_folder_does_not_say(say, tmp_path):
    cell, folder = cell_in("mm", tmp_path), tmp_path / "poses"
    assert say("calibrate", "yumi", "--poses", folder, "--simulate", "--count", 4).code == 0
    listed = folder / "calibration.toml"
    text = listed.read_text()
    listed.write_text(text.replace('unit = "m"', "#"))
    for path in folder.glob("*.ply"):
        points = read_cloud(path, CELL.scanner.T_world_scanner).points
        cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points * 1000))
        assert o3d.io.write_point_cloud(str(path), cloud)
    said = say("calibrate", cell, "--poses", folder, "--json")
    assert said.code == 0, said.err
    assert json.loads(said.out)["rms_mm"] < 1
    # What the folder says comes first.
    listed.write_text(text)
    said = say("calibrate", cell, "--poses", folder)
    assert said.code == 2
    assert "`unit` in calibration.toml" in said.problem


@pytest.mark.parametrize(
    ("true", "read"), [("mm", "m"), ("m", "mm"), ("mm", "inch"), ("inch", "mm")]
)
def test_a_wrong_unit_is_refused_and_the_key_is_named(line, say, tmp_path, true, read):
    points = read_cloud(line.scan, CELL.scanner.T_world_scanner).points
    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points * PER_METRE[true]))
    assert o3d.io.write_point_cloud(str(tmp_path / "scan.pcd"), cloud)
    cell = cell_in(read, tmp_path)
    asked = ("--poses", line.poses, "--scan", tmp_path / "scan.pcd")
    for words in (
        ("localize", cell, "--scan", tmp_path / "scan.pcd", "--out", tmp_path / "poses.json"),
        ("plan", cell, *asked, "--out", tmp_path / "plan.json"),
        ("explain", cell, *asked),
    ):
        said = say(*words)
        assert said.code == 2
        assert "`unit` in [scanner] of the cell file" in said.problem


def test_a_unit_that_nobody_knows_is_refused_by_its_key(line, say, tmp_path):
    cell = cell_in("furlong", tmp_path)
    said = say("localize", cell, "--scan", line.scan, "--out", tmp_path / "poses.json")
    assert said.code == 2
    assert "unit" in said.problem and "furlong" in said.problem
