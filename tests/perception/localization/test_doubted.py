"""Parts that the scan looks through here and there are looked for again."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np

from workbench.formats.parts.reading import read_part
from workbench.model.cell import Cell
from workbench.model.scan import ALL_KINDS
from workbench.perception.localization.assessment import Assessment
from workbench.perception.localization.choice import Choice
from workbench.perception.localization.judging import PartSearch, doubted_apart
from workbench.perception.matching.sightings import Sighting
from workbench.perception.simulation.noise_models import ROUGH
from workbench.perception.simulation.piles import pile_of
from workbench.perception.simulation.synthesize import synthesize
from workbench.plugins.localizer import find_parts
from workbench.studies.localization import DEVIATIONS, compare

KINDS = tuple(read_part(name) for name in ("keyed_cylinder", "bracket", "bolt"))

AREA = 1000
"""Pixels of a part's picture: the n-th those from n * AREA on."""


def a_part(number: int, *, violated: int, is_rim: bool = False) -> Assessment:
    """A part of which so many pixels, at its rim or not, are looked through."""
    seen = Sighting(
        explained=np.arange(number * AREA, (number + 1) * AREA - violated),
        off=np.zeros(AREA - violated),
        violated=np.arange((number + 1) * AREA - violated, (number + 1) * AREA),
        is_rim=np.full(violated, is_rim),
        hidden=np.arange(0),
        ahead=np.zeros(0),
    )
    return Assessment(np.eye(4), seen, None, roll_known=True, is_constrained=True, share=1.0)


def test_what_is_looked_through_in_its_middle_is_taken_out():
    parts = [a_part(0, violated=50), a_part(1, violated=0), a_part(2, violated=50, is_rim=True)]
    claimed = np.repeat(np.arange(3), AREA)
    depth_map = SimpleNamespace(depth=np.zeros((3, AREA)))
    one = PartSearch(
        None, None, depth_map, depth_map, 0.001, 0.0003, all, Choice(claimed, parts, [])
    )  # type: ignore[arg-type]
    left, doubted = doubted_apart(one)
    assert [each.sighting for each in doubted] == [parts[0].sighting]
    assert left.choice.chosen == parts[1:]
    assert (left.choice.claimed == np.repeat([-1, 0, 1], AREA)).all()


def test_a_bracket_whose_legs_were_mistaken_for_each_other_is_found(cell: Cell):
    """One leg is seen, the other one is too steep; the first vote has only poses of the wrong."""
    rough = replace(cell.scanner, depth_noise=DEVIATIONS["rough"])
    there = replace(cell, parts=KINDS, scanner=rough)
    truth = pile_of(there, ALL_KINDS, 8, seed=200002)
    scan = synthesize(there, truth, seed=200002, noise=ROUGH)
    found, is_found = compare(KINDS, truth, find_parts(scan, there, seed=200002).detections)
    assert all(one.is_right for one in found) and all(is_found)
