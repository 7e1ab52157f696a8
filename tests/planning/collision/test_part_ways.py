"""A part alone on its way out of the bin."""

import numpy as np
import pytest

from workbench.formats.cells.reading import read_cell
from workbench.model.geometry import pose_from_rpy
from workbench.model.scan import Detection, Obstacle
from workbench.perception.simulation.piles import drop_parts
from workbench.planning.collision.pairing import NEARER_BY
from workbench.planning.collision.part_ways import MOST_OFF, WAY_START, kept_on_ways
from workbench.planning.collision.world import World

UP = np.array([0.0, 0.0, 0.1])


@pytest.fixture(scope="module")
def cell():
    return read_cell("yumi")


def lying(cell, y: float, z: float = 0.019) -> Detection:
    T = cell.bin.T_world_bin * pose_from_rpy((0, y, z), (0, np.pi / 2, 0))
    return Detection("keyed_cylinder", T)


def test_a_part_with_nothing_on_it_goes_up_but_not_through_the_wall(cell):
    ways = World(cell, (lying(cell, 0.0),)).part_ways
    up, through = ways.find_blocks(0, [UP, np.array([0.0, 0.2, 0.02])])
    assert up is None
    assert through is not None
    label, far = through
    assert label == "bin_wall_left" and 0.1 < far < 0.14


def test_what_lies_on_a_part_blocks_the_way_up(cell):
    ways = World(cell, (lying(cell, 0.0), lying(cell, 0.0, 0.058))).part_ways
    (below,) = ways.find_blocks(0, [UP])
    assert below is not None and below[0] == "part-2"
    assert ways.find_blocks(1, [UP]) == [None]


@pytest.mark.extensive
def test_looking_at_all_places_at_once_finds_what_looking_at_each_finds(cell):
    pile = drop_parts(cell.parts[:1] * 6, cell.bin, seed=77)
    ways = [UP, np.array([0.04, 0.0, 0.09])]
    found, keeps = World(cell, pile).part_ways, kept_on_ways(cell)
    assert 0 < keeps < cell.policy.near_margin
    blocked = 0
    for number, one in enumerate(pile):
        others = [other for other in range(len(pile)) if other != number]
        for way, met in zip(ways, found.find_blocks(number, ways), strict=True):
            touches = False
            most = float(np.linalg.norm(way))
            for far in [*np.arange(cell.policy.release, most, 0.004), most]:
                T = one.T_world_part.copy()
                T.translation = T.translation + far * way / most
                moved = World(cell, (*pile, Detection(one.part, T))).part_ways
                touches |= min(moved.gap(len(pile), k) for k in others) < keeps
            by_parts = met is not None and not met[0].startswith("bin_")
            assert by_parts == touches or (met is not None and not by_parts)
            blocked += touches
    assert blocked > 0


def test_parts_apart_have_the_gap_between_them(cell):
    ways = World(cell, (lying(cell, -0.03), lying(cell, 0.03))).part_ways
    # Two collars of 19 mm.
    assert ways.gap(0, 1) == pytest.approx(0.06 - 0.038, abs=1e-6)
    assert ways.gap(1, 0) == pytest.approx(ways.gap(0, 1))


def test_parts_that_touch_are_of_one_heap_also_through_others(cell):
    row = tuple(lying(cell, y) for y in (-0.1, -0.0605, 0.1, -0.021))
    found = World(cell, row).part_ways
    assert found.gap(0, 3) > 0.03
    first, second, alone, third = found.heaps(0.002)
    assert first == second == third != alone
    assert len(set(found.heaps(0.0))) == 4


@pytest.mark.parametrize("length", [0.0, 0.0005])
def test_a_way_that_ends_before_the_part_has_come_off_meets_nothing(cell, length):
    assert length < cell.policy.release
    ways = World(cell, (lying(cell, 0.0), lying(cell, 0.0, 0.057))).part_ways
    with np.errstate(all="raise"):
        assert ways.find_blocks(0, [length * UP / 0.1]) == [None]


def test_a_part_that_lies_against_a_wall_gains_by_leaning_away_and_only_rubs_straight_up(cell):
    half = float(cell.bin.size[1]) / 2
    # The collar of 19 mm touches the wall's inner face, and the floor.
    ways = World(cell, (lying(cell, half - 0.019),)).part_ways
    assert ways.gain(0, UP) == pytest.approx(0.0, abs=1e-6)
    away, into = np.array([0.0, -0.06, 0.08]), np.array([0.0, 0.06, 0.08])
    assert ways.gain(0, away) == pytest.approx(0.6 * WAY_START, abs=1e-6)
    assert ways.gain(0, into) == pytest.approx(-0.6 * WAY_START, abs=1e-6)


def test_a_part_gains_on_the_neighbour_it_lies_against_least_of_all_counts(cell):
    beside = lying(cell, 0.0), lying(cell, 0.0381)
    ways = World(cell, beside).part_ways
    aside, alone = np.array([0.0, -0.06, 0.08]), World(cell, beside[:1]).part_ways
    assert 0 < ways.gain(0, aside) < alone.gain(0, aside)
    assert ways.gain(0, UP) < 0.1 * WAY_START < ways.gain(0, aside)
    assert ways.gain(1, aside) < 0, "it is pushed into the other"


def test_what_is_not_near_does_not_count_and_no_way_gains_more_than_it_is_long(cell):
    high = lying(cell, 0.0, 0.019 + cell.policy.near_margin + 1e-4)
    ways = World(cell, (high,)).part_ways
    assert ways.gain(0, -UP) == WAY_START
    assert ways.gain(0, 0.001 * UP / 0.1) == pytest.approx(0.001)
    assert ways.gain(0, 0.0 * UP) == 0.0


def test_ways_off_lead_a_part_out_from_under_what_reaches_over_it(cell):
    """Judged by the distances of the parts themselves, every 3 mm of the way."""
    # Another one reaches across it from one side: it only comes out to the other one.
    one = lying(cell, 0.0)
    half = float(np.abs(cell.parts[0].mesh.points[:, 2]).max())
    T = cell.bin.T_world_bin * pose_from_rpy((0.0, half + 0.008, 0.06), (np.pi / 2, 0, 0))
    both = (one, Detection(one.part, T))
    ways = World(cell, both).part_ways
    off = ways.ways_off(0)
    assert ways.find_blocks(0, [UP])[0] is not None and 0 < len(off) <= MOST_OFF
    for way in off:
        assert np.linalg.norm(way) == pytest.approx(cell.policy.lift_length)
        assert way[2] >= 0.5 * cell.policy.lift_length - 1e-9
        gaps = []
        for far in np.arange(0.0, cell.policy.lift_length, 0.003):
            moved = one.T_world_part.copy()
            moved.translation = one.T_world_part.translation + far * way / np.linalg.norm(way)
            gaps.append(World(cell, (Detection(one.part, moved), both[1])).part_ways.gap(0, 1))
        free = int(np.ceil(cell.policy.release / 0.003))
        assert min(gaps[: free + 1]) >= min(gaps[0], cell.policy.near_margin) - NEARER_BY
        assert min(gaps[free:]) >= kept_on_ways(cell)
    again = World(cell, both).part_ways.ways_off(0)
    assert all(np.array_equal(a, b) for a, b in zip(off, again, strict=True))


def test_a_part_that_lies_free_comes_off_straight_up_first(cell):
    off = World(cell, (lying(cell, 0.0),)).part_ways.ways_off(0)
    assert off[0] == pytest.approx([0.0, 0.0, cell.policy.lift_length])


def test_a_part_under_a_roof_has_no_way_off(cell):
    T = cell.bin.T_world_bin * pose_from_rpy((0.0, 0.0, 0.06))
    roof = Obstacle(T, np.array([0.3, 0.4, 0.01]))
    assert World(cell, (lying(cell, 0.0),), (roof,)).part_ways.ways_off(0) == ()
