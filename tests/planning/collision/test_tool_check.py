"""The tool alone in the bin: all ways of all hands at once, and each by itself."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from workbench.formats.cells.reading import read_cell
from workbench.formats.parts.reading import read_part
from workbench.model.geometry import Mesh, pose_from_rpy
from workbench.model.scan import Obstacle
from workbench.perception.simulation.piles import drop_parts
from workbench.planning.collision.hands import Hands, turns_of
from workbench.planning.collision.legs import grips, openings
from workbench.planning.collision.part_ways import kept_on_ways, steps_along
from workbench.planning.collision.world import World


def met_one_by_one(cell, check, arm, grasp, number, one, *, opening, turn):
    """What a hand meets in one of its ways, with the opening at which it does."""
    T = one.T_world_part * grasp.T_part_tcp * grips(arm.tool, grasp)[turn]
    wide = [(opening, 0.0)] if arm.tool.fingers else []
    for opened, press in [*wide, (grasp.grip if arm.tool.fingers else 0.0, arm.tool.press)]:
        met = check.contact(arm, T, opened, number, press)
        if met is not None:
            return met, opened
    return None


def ways_of(cell, arm, grasp):
    for opening in openings(arm.tool, grasp, cell.policy.least_air):
        for turn in range(len(grips(arm.tool, grasp))):
            yield opening, turn


def compared(cell, pile, arm, obstacles=()):
    """Fits of every grasp of every part, and what looking at way after way brings."""
    check = World(cell, pile, obstacles).tool_check
    told, by_one = [], []
    for part in cell.parts:
        rows = [
            (number, k)
            for number, one in enumerate(pile)
            if one.part == part.name
            for k in range(len(part.grasps))
        ]
        for (number, k), fit in zip(rows, check.fits(arm, part.grasps, rows), strict=True):
            grasp, one = part.grasps[k], pile[number]
            if fit.pair is None:
                told.append((fit.opening if arm.tool.fingers else grasp.opening, fit.turn))
            else:
                opening = grasp.grip if fit.is_closed else fit.opening
                T = one.T_world_part * grasp.T_part_tcp
                told.append(
                    check.measure_pair(arm, T, opening if arm.tool.fingers else 0.0, fit.pair)
                )
                assert fit.is_touching == (told[-1][1] <= 0.0), told[-1]
            first, found = None, None
            for opening, turn in ways_of(cell, arm, grasp):
                met = met_one_by_one(
                    cell, check, arm, grasp, number, one, opening=opening, turn=turn
                )
                first = first or met
                if met is None:
                    found = (opening, turn)
                    break
            by_one.append(found or first[0])
    return told, by_one


@pytest.mark.extensive
@pytest.mark.parametrize(
    ("cell_name", "kinds", "seed", "least_air"),
    [
        ("yumi", ("keyed_cylinder",) * 9, 4, None),
        ("yumi", ("bracket", "bolt") * 4, 5, 0.001),
        ("yumi", ("keyed_cylinder/full_bin",) * 3, 7, 0.0015),
        ("tx2_90", ("puck",) * 9, 6, None),
    ],
)
def test_all_hands_at_once_fit_and_meet_as_each_by_itself(cell_name, kinds, seed, least_air):
    parts = {name: read_part(f"parts/{name}") for name in kinds}
    cell = read_cell(cell_name)
    policy = replace(cell.policy, least_air=least_air)
    cell = replace(cell, parts=tuple(parts.values()), policy=policy)
    pile = drop_parts(tuple(parts[name] for name in kinds), cell.bin, seed=seed)
    box = Obstacle(cell.bin.T_world_bin * pose_from_rpy((0.03, 0.02, 0.04)), np.full(3, 0.02))
    for arm in cell.arms:
        told, by_one = compared(cell, pile, arm, (box,))
        assert told == by_one
        assert any(isinstance(one[0], float) for one in told)
        assert any(isinstance(one[0], tuple) for one in told)


def test_a_body_that_is_not_convex_is_measured_one_by_one():
    cell = read_cell("yumi")
    pile = drop_parts(cell.parts[:1] * 3, cell.bin, seed=2)
    # A tray of two triangles, above the bin: no compiled code knows it.
    points = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]) * 0.05
    flat = Mesh(points, np.array([[0, 1, 2], [0, 2, 3]]), is_convex=False)
    solid = replace(cell.fixtures[0].solids[0], shape=flat, T_owner_shape=pose_from_rpy((0, 0, 0)))
    lid = replace(
        cell.fixtures[0],
        solids=(solid,),
        T_world_fixture=cell.bin.T_world_bin * pose_from_rpy((0, 0, 0.06)),
    )
    cell = replace(cell, fixtures=(lid,))
    told, by_one = compared(cell, pile, cell.arms[0])
    assert told == by_one
    assert any(isinstance(one[0], tuple) and one[0][1] == solid.name for one in told)


def test_ways_judged_all_at_once_fit_as_each_by_itself():
    cell = read_cell("yumi")
    part, arm = read_part("parts/keyed_cylinder/full_bin"), cell.arms[0]
    pile = drop_parts((part,) * 9, cell.bin, seed=4)
    check = World(replace(cell, parts=(part,)), pile).tool_check
    arrays = zip(*(turns_of(arm.tool, grasp)[1:] for grasp in part.grasps), strict=True)
    R, p, opening, turn, cuts = map(np.concatenate, arrays)
    every = Hands(np.arange(len(turn) + 1), R, p, opening, turn, cuts)
    # A grasp of twice the same way is judged by the code that finds out what it meets.
    twice = Hands(every.first * 2, *(np.repeat(array, 2, axis=0) for array in every[1:]))
    fits = [check.free(arm, number, every) for number in range(len(pile))]
    assert np.array_equal(fits, [check.free(arm, number, twice) for number in range(len(pile))])
    assert 0.01 < np.mean(fits) < 0.99


def test_no_hands_meet_nothing():
    cell = read_cell("yumi")
    arm, part = cell.arms[0], cell.parts[0]
    assert World(cell, ()).tool_check.fits(arm, part.grasps, []) == []


def test_a_hand_on_its_way_meets_the_first_thing_that_it_meets_anywhere_on_it():
    cell = read_cell("yumi")
    (arm, *_), part = cell.arms, cell.parts[0]
    pile = drop_parts((part,) * 4, cell.bin, seed=5)
    check, keeps = World(cell, pile).tool_check, kept_on_ways(cell)
    near = replace(cell, policy=replace(cell.policy, near_margin=keeps))
    closer = World(near, pile).tool_check
    rng, hits = np.random.default_rng(3), 0
    for k in range(40):
        x, y = rng.uniform(-0.08, 0.08), rng.uniform(-0.12, 0.12)
        T = cell.bin.T_world_bin * pose_from_rpy((x, y, rng.uniform(0.03, 0.09)), (np.pi, 0, k))
        way = rng.normal(0, 0.05, 3)
        met = check.on_way(arm, T, 0.03, 0, way)
        far = steps_along(0.0, float(np.linalg.norm(way)))
        first = None
        for s in far:
            at = pin.SE3(T.rotation, T.translation + s * way / np.linalg.norm(way))
            found = closer.contact(arm, at, 0.03, 0, 1.0)
            if found is not None:
                first = s
                break
        assert (met is None) == (first is None), k
        if met is not None:
            assert met[1] == pytest.approx(first)
            assert met[0][0].startswith(arm.name)
            hits += 1
    assert 5 < hits < 40


def test_a_hand_that_goes_nowhere_meets_nothing_on_its_way():
    cell = read_cell("yumi")
    arm, pile = cell.arms[0], drop_parts(cell.parts[:1] * 4, cell.bin, seed=5)
    T = cell.bin.T_world_bin * pose_from_rpy((0, 0, 0.03), (np.pi, 0, 0))
    with np.errstate(all="raise"):
        assert World(cell, pile).tool_check.on_way(arm, T, 0.03, 0, np.zeros(3)) is None
