"""`workbench calibrate`: from a folder of scans to a cell file, and what stands against it."""

import json
import shutil

import numpy as np
import pytest

from workbench.cli.calibrating.calibrate import WRONG
from workbench.formats.cells.reading import read_cell


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    from workbench.cli.main import main

    folder = tmp_path_factory.mktemp("calibration") / "poses"
    words = ["calibrate", "yumi", "--poses", str(folder), "--simulate", "--count", "6"]
    assert main(words) == 0
    return folder


def test_a_simulated_mount_is_found_and_saved(say, folder, cell_file):
    said = say("calibrate", cell_file, "--poses", folder, "--json", "--save", "--by", "Anna")
    assert said.code == 0
    form = json.loads(said.out)
    assert form["ok"] and len(form["poses"]) == 6
    assert {pose["light"] for pose in form["poses"]} == {"good"}
    assert all(pose["off_mm"] < pose["predicted_mm"] < 0.5 for pose in form["poses"])
    assert form["rms_mm"] < form["predicted_rms_mm"] < 0.4
    assert form["largest_corner_mm"] == max(form["corners_mm"].values()) < 1.5
    assert np.array(form["covariance"]).shape == (6, 6) and len(form["corners_mm"]) == 8
    assert form["rms_mm"] < 0.1 and 20 < form["moved_mm"] < 22
    mount = read_cell(cell_file).scanner
    off = (read_cell("yumi").scanner.T_world_scanner * WRONG).actInv(mount.T_world_scanner)
    assert np.linalg.norm(off.translation) < 0.0005
    assert np.allclose(mount.calibration.covariance, form["covariance"], rtol=1e-6)
    assert (mount.calibration.by, mount.calibration.poses) == ("Anna", 6)
    log = (cell_file.parent / "changes.log").read_text()
    assert "Anna" in log and "calibrated by 6 poses" in log


def test_the_pose_to_take_next_is_told_on_request(say, folder):
    said = say("calibrate", "yumi", "--poses", folder, "--next")
    assert said.code == 0 and "next, from pose_6.ply: " in said.out
    assert "that would bring the worst corner from" in said.out and "joints_deg = [" in said.out
    form = json.loads(say("calibrate", "yumi", "--poses", folder, "--next", "--json").out)
    (best,) = form["next"]
    assert best["after"] == "pose_6.ply" and len(best["joints_deg"]) == 7 and best["steps"]
    assert 0 < best["largest_corner_mm"] < form["largest_corner_mm"]


def test_a_wrong_joint_value_is_named(say, folder, tmp_path):
    shutil.copytree(folder, tmp_path / "bad")
    file = tmp_path / "bad" / "calibration.toml"
    lines = file.read_text().splitlines()
    number = max(k for k, text in enumerate(lines) if text.startswith("joints_deg"))
    first, rest = lines[number].split("[")[1].split(",", 1)
    lines[number] = f"joints_deg = [{float(first) + 2.0}, {rest}"
    file.write_text("\n".join(lines))
    said = say("calibrate", "yumi", "--poses", tmp_path / "bad")
    assert said.code == 0
    assert "pose_6.ply" in said.out and "left out" in said.out and "5 poses" in said.out


def test_a_scan_without_the_plate_is_told(say, folder, tmp_path):
    shutil.copytree(folder, tmp_path / "gap")
    assert say("scan", "yumi", "--out", tmp_path / "gap" / "pose_2.ply").code == 0
    said = say("calibrate", "yumi", "--poses", tmp_path / "gap")
    assert said.code == 0
    assert "left out: pose_2.ply: the plate is not seen" in said.out
    form = json.loads(say("calibrate", "yumi", "--poses", tmp_path / "gap", "--json").out)
    assert len(form["not_seen"]) == 1 and form["not_seen"][0].startswith("pose_2.ply")


def test_what_cannot_be_done_is_refused_in_a_line(say, folder, tmp_path):
    said = say("calibrate", "yumi", "--poses", folder, "--save")
    assert said.code == 2 and "--save needs --by NAME" in said.problem
    said = say("calibrate", "yumi", "--poses", folder, "--simulate")
    assert said.code == 2 and "is there already" in said.problem
    said = say("calibrate", "yumi", "--poses", tmp_path / "nowhere")
    assert said.code == 2 and "calibration.toml" in said.problem
    said = say("calibrate", "yumi", "--poses", tmp_path / "few", "--simulate", "--count", "3")
    assert said.code == 2 and "--count" in said.problem


def test_localize_tells_of_the_bin_and_takes_wishes(say, line, tmp_path):
    out = ("--out", tmp_path / "poses.json")
    said = say("localize", "yumi", "--scan", line.scan, *out, "--detail", "1.4")
    assert said.code == 0 and "bin, good: the bin is where it should be" in said.out
    assert "2 found" in " ".join(said.out.split())  # whatever the length of its path
    said = say("localize", "yumi", "--scan", line.scan, *out, "--least-score", "0.999")
    assert "0 found" in " ".join(said.out.split())
    said = say("localize", "yumi", "--scan", line.scan, *out, "--detail", "7")
    assert said.code == 2 and "--detail must lie between 0.3 and 2" in said.problem
