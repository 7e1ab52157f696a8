"""Which bin a first cell gets: one from which parts are taken, if there is such."""

from dataclasses import replace

import pytest

from workbench.formats.cells.reading import read_cell
from workbench.model.cell import Cell
from workbench.model.errors import InputError
from workbench.model.geometry import pose_from_rpy
from workbench.studies.layout import bins
from workbench.studies.layout.homes import side_of
from workbench.studies.layout.trial import takes_parts


@pytest.fixture(scope="module")
def cell() -> Cell:
    return read_cell("yumi")


def moved(cell: Cell, x: float) -> Cell:
    T = pose_from_rpy((x, 0, 0)) * cell.bin.T_world_bin
    return replace(cell, bin=replace(cell.bin, T_world_bin=T))


def laid_out(cell: Cell, monkeypatch, spots, serves) -> bins.LaidOut:
    """What becomes of whole cells at shifts [m] with shares that are reached."""
    found = [bins._Spot(moved(cell, x), reached, reached) for x, reached in spots]
    monkeypatch.setattr(bins, "_complete", lambda *_: iter(found))
    monkeypatch.setattr(bins, "takes_parts", lambda tried: shift(cell, tried) in serves)
    return bins.laid_out(cell)


def shift(cell: Cell, tried: Cell) -> float:
    away = tried.bin.T_world_bin.translation - cell.bin.T_world_bin.translation
    return round(float(away[0]), 3)


def test_a_bin_from_which_nothing_is_taken_gives_way_to_the_next(cell, monkeypatch):
    found = laid_out(cell, monkeypatch, [(0.1, 1.0), (0.2, 0.9)], {0.2})
    assert shift(cell, found.cell) == 0.2
    assert not any("no plan" in note for note in found.notes)


def test_where_no_bin_serves_the_best_reached_is_taken_and_that_is_said(cell, monkeypatch):
    found = laid_out(cell, monkeypatch, [(0.1, 0.8), (0.2, 0.9)], set())
    assert shift(cell, found.cell) == 0.2
    assert any("there is no plan for a simulated pile" in note for note in found.notes)


def test_a_bin_of_which_little_is_reached_serves_where_no_better_one_does(cell, monkeypatch):
    found = laid_out(cell, monkeypatch, [(0.1, 1.0), (0.2, 0.3)], {0.2})
    assert shift(cell, found.cell) == 0.2


def test_a_search_that_takes_long_ends_with_the_best_bin_so_far(cell, monkeypatch):
    now = iter(range(0, 1000, 10))
    monkeypatch.setattr(bins, "processor_time", lambda: float(next(now)))
    found = [bins._Spot(moved(cell, 0.1), 0.3, 0.3), bins._Spot(moved(cell, 0.2), 1.0, 1.0)]
    tried = []

    def complete(cell, report, is_late):
        for spot in found:
            if is_late():
                return
            tried.append(spot)
            yield spot

    monkeypatch.setattr(bins, "_complete", complete)
    monkeypatch.setattr(bins, "takes_parts", lambda tried: False)
    assert shift(cell, bins.laid_out(cell).cell) == 0.2
    assert len(tried) == 2


def test_a_search_that_finds_no_bin_ends_too(cell, monkeypatch):
    now, sizes = iter(range(0, 1000, 25)), []
    monkeypatch.setattr(bins, "processor_time", lambda: float(next(now)))
    monkeypatch.setattr(bins, "_complete", lambda cell, *_: sizes.append(cell.bin.size) or iter(()))
    with pytest.raises(InputError, match="no bin of "):
        bins.laid_out(cell)
    assert 1 <= len(sizes) < len(bins.SIZES)


def test_where_two_arms_reach_no_bin_the_message_names_the_flanges_to_take_one_arm(
    cell, monkeypatch
):
    monkeypatch.setattr(bins, "_complete", lambda *_: iter(()))
    first, second = (arm.flange for arm in cell.arms)
    with pytest.raises(InputError, match=f"alone: --flange {first} or {second}"):
        bins.laid_out(cell)


def test_where_an_arm_with_five_axes_reaches_no_bin_the_message_states_its_axes(cell, monkeypatch):
    monkeypatch.setattr(bins, "_complete", lambda *_: iter(()))
    arm = replace(cell.arms[0], joints=cell.arms[0].joints[:5])
    with pytest.raises(InputError, match="with 5 axes an arm cannot turn"):
        bins.laid_out(replace(cell, arms=(arm,)))


def test_the_table_that_is_added_counts_in_what_the_arms_reach(cell, monkeypatch):
    bare, tables = replace(cell, fixtures=()), []

    def share(tried: Cell) -> float:
        tables.append([fixture.name for fixture in tried.fixtures])
        return 1.0

    monkeypatch.setattr(bins, "_share_reached", share)
    spots = list(bins._spots(bare, lambda: False))
    assert spots
    assert tables == [["table"]] * len(spots)


def test_parts_are_taken_on_trial_where_arms_reach_them_alone(cell):
    assert takes_parts(cell)
    assert not takes_parts(moved(cell, 3.0))
    small = replace(cell, bin=replace(cell.bin, size=cell.bin.size / 20))
    assert not takes_parts(small)


def test_arms_on_one_column_work_at_two_sides(cell):
    assert [side_of(cell, arm) for arm in cell.arms] == [-1.0, 1.0]
    lower = cell.arms[0]
    column = replace(cell, arms=(lower, replace(lower, name="upper", controller_id="U")))
    assert [side_of(column, arm) for arm in column.arms] == [-1.0, 1.0]
