"""`workbench calibrate` of a scanner on an arm: scans of a plate that stands, to a cell file."""

import json
import shutil

import numpy as np
import pytest

from workbench.cli.calibrating.calibrate import WRONG
from workbench.formats.cells.reading import read_cell
from workbench.formats.files.shipped import find


def simulated(robot, count, folder):
    from workbench.cli.main import main

    words = ["calibrate", str(find("robots", robot) / "on_arm.toml"), "--poses", str(folder)]
    assert main([*words, "--simulate", "--count", str(count)]) == 0
    return folder


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return simulated("tx2_90", 5, tmp_path_factory.mktemp("calibration") / "poses")


@pytest.fixture
def cell_file(tmp_path):
    shutil.copytree(find("robots", "tx2_90"), tmp_path / "tx2_90")
    return tmp_path / "tx2_90" / "on_arm.toml"


def saved(say, folder, cell_file):
    """What was printed and the cell file's scanner, before and after."""
    before = read_cell(cell_file).scanner
    said = say("calibrate", cell_file, "--poses", folder, "--json", "--save", "--by", "Anna")
    assert said.code == 0, said.err
    return json.loads(said.out), before, read_cell(cell_file).scanner


@pytest.mark.extensive
def test_a_scanner_on_an_arm_is_calibrated_and_saved(say, folder, cell_file):
    form, before, after = saved(say, folder, cell_file)
    assert {pose["light"] for pose in form["poses"]} == {"good"}
    assert form["largest_corner_mm"] == max(form["corners_mm"].values()) < 1.5
    assert 20 < form["moved_mm"] < 22
    off = (before.on_arm.T_flange_scanner * WRONG).actInv(after.on_arm.T_flange_scanner)
    assert np.linalg.norm(off.translation) < 0.0005
    written = np.array(form["T_flange_scanner"])
    assert np.abs(written - after.on_arm.T_flange_scanner.homogeneous).max() < 1e-6
    assert (after.calibration.by, after.calibration.poses) == ("Anna", 5)
    # Two views stated by the scanner's pose: the arm still looks from where it looked.
    for old, new in zip(before.on_arm.views, after.on_arm.views, strict=True):
        assert np.array_equal(old.q, new.q) and (old.name, old.number) == (new.name, new.number)
    assert "joints_deg" in cell_file.read_text() and "# In the flange's frame" in (
        cell_file.read_text()
    )
    again = json.loads(say("calibrate", cell_file, "--poses", folder, "--json").out)
    assert again["moved_mm"] < 0.01 and again["moved_deg"] < 0.001


@pytest.mark.extensive
def test_views_that_are_stated_by_joints_stay_as_they_are(say, tmp_path):
    shutil.copytree(find("robots", "yumi"), tmp_path / "yumi")
    cell_file = tmp_path / "yumi" / "on_arm.toml"
    folder = simulated("yumi", 5, tmp_path / "poses")
    _, before, after = saved(say, folder, cell_file)
    assert np.array_equal(before.on_arm.view.q, after.on_arm.view.q)
    assert "joints_deg = [-90.3, -33.9, 23.4, 81.2, 109.7, 17.7, 36]" in cell_file.read_text()


@pytest.mark.extensive
def test_the_pose_to_take_next_moves_the_scanner(say, folder, cell_file):
    said = say("calibrate", cell_file, "--poses", folder, "--next")
    assert said.code == 0 and "next, from pose_5.ply: turn the scanner by" in said.out
    assert "its pose below is that in the flange" in said.out and "joints_deg = [" in said.out


@pytest.mark.extensive
def test_the_pose_in_the_flange_is_written_for_other_programs(say, folder, cell_file, tmp_path):
    out = tmp_path / "scanner.yaml"
    said = say("calibrate", cell_file, "--poses", folder, "--write", out, "--style", "ros")
    assert said.code == 0 and "eye_in_hand" in out.read_text()


def test_a_calibration_of_the_other_kind_of_scanner_is_refused(say, folder, cell_file, tmp_path):
    def problem_of(words):
        said = say("calibrate", *words)
        assert said.code == 2
        return " ".join(said.problem.split())

    assert "the scanner of this cell stands" in problem_of(
        (cell_file.with_name("cell.toml"), "--poses", folder)
    )
    assert "--in-hand is for pairs" in problem_of(
        (cell_file.with_name("cell.toml"), "--poses", folder, "--in-hand")
    )
    shutil.copytree(folder, tmp_path / "held")
    listed = tmp_path / "held" / "calibration.toml"
    kept = [text for text in listed.read_text().splitlines() if not text.startswith("stands")]
    listed.write_text("\n".join(kept))
    assert "an arm carries the scanner of this cell; stands = true is expected" in problem_of(
        (cell_file, "--poses", tmp_path / "held")
    )
