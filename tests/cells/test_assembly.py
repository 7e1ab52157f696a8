"""The page "Recipes", its part about assemblies followed literally, and the cell of it."""

import re
import tomllib
from dataclasses import replace
from pathlib import Path

import pinocchio as pin
import pytest
from assembling import assembly_cell, standing_spacer
from page_commands import follow

from workbench.cli.authoring.cell_check import _notes
from workbench.cli.main import main
from workbench.formats.cells.reading import read_cell
from workbench.formats.clouds.scans import write_cloud
from workbench.formats.plans.pose_files import write_poses
from workbench.model.derived.by_recipe import with_recipe
from workbench.model.scan import Detection
from workbench.perception.simulation.synthesize import synthesize

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "recipes.md").read_text(encoding="utf-8")
ASSEMBLY = ROOT / "robots" / "yumi" / "assembly.toml"


@pytest.mark.extensive
def test_the_page_leads_to_a_bolt_with_a_spacer_over_it(tmp_path, monkeypatch, capsys):
    _, block = re.findall(r"```sh\n(.*?)```", PAGE, re.DOTALL)
    assert block.count("\n") == 3
    follow(block, tmp_path, monkeypatch)
    said = capsys.readouterr().out
    assert "then plan-2.json" in said and said.count("the proof holds") == 3


def test_the_item_on_the_page_is_that_of_the_cell():
    _, _, block = re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL)
    (said,) = tomllib.loads(block)["recipe"]["item"]
    shipped = tomllib.loads(ASSEMBLY.read_text(encoding="utf-8"))["recipe"][0]["item"][1]
    assert {"rpy_deg": [0, 0, 0], **said} == shipped


def test_explain_says_how_many_parts_mate_with_a_base_that_stands(tmp_path, capsys):
    cell = assembly_cell()
    write_poses(tmp_path / "poses.json", [standing_spacer(cell)])
    asked = ["explain", str(ASSEMBLY), "--poses", str(tmp_path / "poses.json"), "--recipe", "1"]
    assert main([*asked, "--stands", "bolt"]) == 0
    assert "of picks mate with bolt" in capsys.readouterr().out
    assert main([*asked, "--stands", "spacer"]) == 2
    assert "--stands spacer: the recipe puts no spacer at a place" in capsys.readouterr().err


def test_explain_says_what_a_second_look_at_the_base_gains(tmp_path, capsys):
    cell = with_recipe(read_cell(ASSEMBLY), 2)
    spacer, poses, file = standing_spacer(cell), tmp_path / "poses.json", tmp_path / "scan.ply"
    T = cell.arm("right").part_places[0].T_world_part
    off = pin.SE3(T.rotation, T.translation + [0.003, -0.002, -0.006])
    write_cloud(file, synthesize(cell, (spacer, Detection("bolt", off)), seed=2))
    write_poses(poses, [spacer])
    asked = ["explain", str(ASSEMBLY), "--poses", str(poses), "--recipe", "2", "--stands", "bolt"]
    assert main([*asked, "--scan", str(file)]) == 0
    assert "(before bolt was seen: " in capsys.readouterr().out
    assert main(asked) == 3
    assert "bolt has to be seen in the scan" in " ".join(capsys.readouterr().out.split())


def test_a_joint_that_takes_less_than_the_calibration_is_off_is_noted():
    cell = read_cell(ASSEMBLY)
    assert not [note for note in _notes(cell) if "joint" in note]
    item = cell.recipes[0].items[1]
    joint = replace(item.insertion.joint, clearance=0.0005, compliance=0.0)
    narrow = replace(item, insertion=replace(item.insertion, joint=joint))
    recipe = replace(cell.recipes[0], items=(cell.recipes[0].items[0], narrow))
    (note,) = (note for note in _notes(replace(cell, recipes=(recipe,))) if "joint" in note)
    assert note == (
        "recipe 1: the joint of spacer and bolt takes 0.5 mm, and the calibration alone is off by "
        "1.8 mm in the bin (95%, along one axis)"
    )


def test_the_cell_that_assembles_is_that_with_nests_but_for_its_parts():
    cell, nests = read_cell(ASSEMBLY), read_cell(ASSEMBLY.parent / "nests.toml")
    assert [fixture.name for fixture in cell.fixtures] == [one.name for one in nests.fixtures]
    for one, other in zip(cell.arms, nests.arms, strict=True):
        assert (one.home == other.home).all() and one.joints == other.joints
    full = read_cell(ASSEMBLY.parent / "full_bin.toml")
    assert cell.policy == full.policy
