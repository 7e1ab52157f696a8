"""`workbench calibrate` by pairs of poses of another program."""

import json
import shutil

import numpy as np
import pinocchio as pin
import pytest
from held_plates import CENTRES, X, Y, scene

from workbench.formats.cells.reading import read_cell
from workbench.formats.files.shipped import find
from workbench.perception.calibration.rigid import fitted_motion


def pairs_file(path, *, in_hand):
    """Pairs of a scene in which the scanner is at X and the target is held at Y."""
    rows = []
    for pose in scene(7, count=12, shift=2e-4, turn=np.deg2rad(0.02)):
        T = pose.T_world_flange.inverse() if in_hand else pose.T_world_flange
        target = pin.SE3(*fitted_motion(CENTRES, pose.balls))
        rows.append(",".join(map(str, [*pin.SE3ToXYZQUAT(T), *pin.SE3ToXYZQUAT(target)])))
    path.write_text("\n".join(rows))
    return path


@pytest.mark.parametrize("in_hand", [True, False])
def test_pairs_give_the_scanner_and_the_target(say, tmp_path, in_hand):
    path = pairs_file(tmp_path / "pairs.csv", in_hand=in_hand)
    words = ["calibrate", "yumi", "--poses", path, "--json", *(["--in-hand"] if in_hand else [])]
    form = json.loads(say(*words).out)
    assert form["ok"] and form["pairs"] == len(form["poses"]) == 12
    found = np.array(form["T_flange_scanner" if in_hand else "T_world_scanner"])
    held = np.array(form["T_base_target" if in_hand else "T_flange_target"])
    assert np.abs(found - X.homogeneous).max() < 2e-3
    assert np.abs(held - Y.homogeneous).max() < 2e-3


@pytest.mark.parametrize("in_hand", [True, False])
def test_who_holds_the_scanner_is_noticed(say, tmp_path, in_hand):
    path = pairs_file(tmp_path / "pairs.csv", in_hand=in_hand)
    said = say("calibrate", "yumi", "--poses", path, *([] if in_hand else ["--in-hand"]))
    hint = "state --in-hand" if in_hand else "leave out --in-hand"
    assert said.code == 2 and hint in said.err


def test_a_scanner_that_stands_is_saved_and_written(say, tmp_path):
    shutil.copytree(find("robots", "yumi"), tmp_path / "yumi")
    cell_file = tmp_path / "yumi" / "cell.toml"
    path = pairs_file(tmp_path / "pairs.csv", in_hand=False)
    words = ["--save", "--by", "Anna", "--write", tmp_path / "scanner.yaml", "--style", "ros"]
    said = say("calibrate", cell_file, "--poses", path, *words)
    assert said.code == 0 and "12 poses" in said.out
    cell = read_cell(cell_file)
    assert cell.scanner.calibration.by == "Anna"
    assert np.abs(cell.scanner.T_world_scanner.homogeneous - X.homogeneous).max() < 2e-3
    assert "eye_on_base" in (tmp_path / "scanner.yaml").read_text()


def test_a_scanner_on_an_arm_is_saved_into_its_table(say, tmp_path):
    shutil.copytree(find("robots", "yumi"), tmp_path / "yumi")
    cell_file = tmp_path / "yumi" / "on_arm.toml"
    before = read_cell(cell_file).scanner.on_arm
    path = pairs_file(tmp_path / "pairs.csv", in_hand=True)
    words = ["--in-hand", "--save", "--by", "Anna"]
    said = say("calibrate", cell_file, "--poses", path, *words)
    assert said.code == 0, said.err
    carrier = read_cell(cell_file).scanner.on_arm
    assert np.abs(carrier.T_flange_scanner.homogeneous - X.homogeneous).max() < 2e-3
    assert np.array_equal(carrier.view.q, before.view.q)
    assert "# In the flange's frame" in cell_file.read_text()
    assert read_cell(cell_file).scanner.calibration.by == "Anna"
    assert "what lies at the corners of" in " ".join(said.out.split())


def test_a_scanner_on_an_arm_is_not_calibrated_as_one_that_stands(say, tmp_path):
    path = pairs_file(tmp_path / "pairs.csv", in_hand=False)
    said = say("calibrate", find("robots", "yumi") / "on_arm.toml", "--poses", path)
    assert said.code == 2 and "hangs on the left arm" in said.err


def test_pairs_that_do_not_belong_together_are_refused(say, tmp_path):
    path = pairs_file(tmp_path / "pairs.csv", in_hand=False)
    rows = [row.split(",") for row in path.read_text().splitlines()]
    mixed = [[*row[:7], *other[7:]] for row, other in zip(rows, reversed(rows), strict=True)]
    path.write_text("\n".join(map(",".join, mixed)))
    said = say("calibrate", "yumi", "--poses", path)
    assert said.code == 2 and "the poses are in conflict" in said.err


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("--in-hand", "--save", "--by", "Anna"), "--save with --in-hand needs [scanner.on_arm]"),
        (("--next",), "--simulate and --next need scans"),
    ],
)
def test_what_pairs_cannot_do_is_said(say, tmp_path, words, says):
    path = pairs_file(tmp_path / "pairs.csv", in_hand=True)
    said = say("calibrate", "yumi", "--poses", path, *words)
    assert said.code == 2 and says in said.err
