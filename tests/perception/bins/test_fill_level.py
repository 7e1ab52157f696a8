"""How many parts were found, and of about how many."""

from dataclasses import replace

import pytest

from workbench.formats.parts.reading import read_part
from workbench.model.scan import Scan
from workbench.perception.bins.bin_check import check_bin
from workbench.perception.bins.fill_level import parts_in_words
from workbench.perception.simulation.piles import drop_parts
from workbench.perception.simulation.synthesize import synthesize


@pytest.mark.extensive
@pytest.mark.parametrize("has_walls", [True, False])
@pytest.mark.parametrize("kind", ["keyed_cylinder", "bracket", "bolt", "puck"])
def test_where_all_are_found_no_more_are_told_and_where_few_are_about_how_many(
    cell, kind, has_walls
):
    part = read_part(kind)
    cell = replace(cell, parts=(part,), bin=replace(cell.bin, has_walls=has_walls))
    pile = drop_parts((part,) * 8, cell.bin, seed=17)
    check = check_bin(synthesize(cell, pile, seed=17), cell.bin)
    assert str(parts_in_words(cell, check, pile)) == f"{len(pile)} parts"
    few, *words = str(parts_in_words(cell, check, pile[:2])).split()
    assert (few, words[:2], words[3]) == ("2", ["of", "about"], "parts")
    assert 0.65 * len(pile) <= int(words[2]) <= 1.6 * len(pile)


def test_nothing_is_guessed_of_an_empty_bin(cell):
    check = check_bin(synthesize(cell, (), seed=0), cell.bin)
    assert str(parts_in_words(cell, check, ())) == "0 parts"


@pytest.mark.parametrize("has_walls", [True, False])
def test_of_an_empty_bin_that_is_half_seen_only_that_half_is_said_to_be_empty(cell, has_walls):
    bin = replace(cell.bin, has_walls=has_walls)
    scan = synthesize(cell, (), seed=0)
    T = bin.T_world_bin.inverse() * scan.T_world_scanner
    y = (scan.points @ T.rotation.T + T.translation)[:, 1]
    assert "lies on the floor" in str(check_bin(scan, bin).says)
    half = Scan(scan.points[y < 0], scan.T_world_scanner, "half")
    assert "lies on the 50% of the floor" in str(check_bin(half, bin).says)
