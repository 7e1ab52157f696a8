"""`workbench study pallets` as it is typed, and what it is made of."""

import json

import numpy as np
import pytest

from workbench.app.picking.pallets import at_rest
from workbench.cli.main import main
from workbench.formats.cells.reading import read_cell
from workbench.model.geometry import pose_from_rpy
from workbench.model.scan import Detection
from workbench.perception.simulation.stacks import let_go


@pytest.fixture(scope="module")
def cell():
    return read_cell("robots/tx2_90/pallet.toml")


def test_a_pallet_is_filled_and_stands(capsys):
    typed = ["study", "pallets", "--pallets", "1", "--parts", "3", "--seed", "3"]
    assert main([*typed, "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["places"] == 8 and 0 < said["parts"] <= 8
    assert said["stand"] == 1 and said["off"] == 0 and said["shift_mm"] < 4.0
    assert said["piles"] == said["parts"] + said["unplanned"]


def test_physics_has_parts_where_they_are_said_to_fall_to(cell):
    parts = [Detection("puck", one.T_world_part) for one in cell.arms[0].part_places]
    lie = let_go(cell, [(cell.part(one.part), one.T_world_part) for one in parts])
    for T, meant in zip(lie, at_rest(cell, parts), strict=True):
        assert np.linalg.norm(T.translation - meant.translation) < 0.001
        assert T.rotation[2, 2] > np.cos(np.deg2rad(0.5))


def test_physics_lets_fall_what_nothing_carries(cell):
    place = cell.arms[0].part_places[4].T_world_part
    beside = pose_from_rpy((-0.13, 0.0, 0.0)) * place
    (lies,) = let_go(cell, [(cell.part("puck"), beside)])
    assert lies.translation[2] < 0.05


@pytest.mark.parametrize(
    ("typed", "sentence"),
    [
        (["--pallets", "0"], "--pallets"),
        (["--parts", "0"], "--parts"),
        (["--off-mm", "-1"], "--off-mm"),
        (["--seed", "-1"], "--seed"),
        (["--part", "nothing"], "nothing"),
        (["yumi", "--pallets", "1"], "has no pallet in layers: a grid of three numbers"),
    ],
)
def test_what_makes_no_sense_is_refused_in_one_sentence(say, typed, sentence):
    said = say("study", "pallets", *typed)
    assert said.code == 2 and sentence in said.problem
