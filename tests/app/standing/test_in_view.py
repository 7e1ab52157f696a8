"""Whether the scanner views the places of bases, as `cell check` reports it."""

from dataclasses import replace

import numpy as np
import pytest

from workbench.app.standing.in_view import base_places
from workbench.cli.authoring.cell_check import _notes, _unseen_bases
from workbench.formats.cells.reading import read_cell
from workbench.formats.files.shipped import find
from workbench.model.geometry import pose_from_rpy
from workbench.model.part import PartPlace
from workbench.model.robot import ScanPosture

CELL = read_cell(find("robots", "yumi") / "assembly.toml")


def with_scanner(**changes):
    return replace(CELL, scanner=replace(CELL.scanner, **changes))


def test_the_shipped_scanner_views_both_nests():
    found = list(base_places(CELL))
    assert [(place.recipe, place.base, place.arm) for place in found] == [
        (2, "bolt", "right"),
        (2, "bolt", "left"),
    ]
    assert all(place.seen_from == ("",) for place in found)
    assert list(_unseen_bases(CELL)) == []


@pytest.mark.parametrize(
    "changes", [{"field_of_view": np.deg2rad(26)}, {"far": 0.7}, {"near": 0.8}]
)
def test_a_place_that_no_view_shows_is_a_problem(changes):
    first, _ = _unseen_bases(with_scanner(**changes))
    assert first == (
        "recipe 2: look_again needs bolt in the scan, and place 1 of the right arm is in no view "
        "of the scanner"
    )


def test_without_the_key_no_place_has_to_be_viewed():
    believed = replace(CELL, recipes=CELL.recipes[:1])
    assert list(base_places(believed)) == []


def test_a_place_that_only_some_views_show_is_noted():
    cell = read_cell(find("robots", "yumi") / "on_arm.toml")
    carrier = cell.scanner.on_arm
    assert carrier is not None
    away = ScanPosture("away", carrier.home)
    arms = tuple(
        replace(
            arm,
            Ts_world_place=(),
            place_names=(),
            # In the middle of the bin, which the view shows.
            part_places=(PartPlace(cell.bin.T_world_bin * pose_from_rpy((0, 0, 0.05)), "bolt"),),
        )
        for arm in cell.arms
    )
    mount = replace(cell.scanner, on_arm=replace(carrier, other_views=(away,)))
    both = replace(cell, parts=CELL.parts, recipes=CELL.recipes[1:], arms=arms[:1], scanner=mount)
    (place,) = base_places(both)
    assert (place.seen_from, place.views) == ((carrier.view.name,), 2)
    note = f"recipe 2: bolt at place 1 of the {arms[0].name} arm is only viewed from "
    assert note + carrier.view.name in list(_notes(both))
