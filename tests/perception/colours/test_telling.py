"""Kinds and turns that shape leaves open, told by the colours of rendered scans."""

from dataclasses import replace

import numpy as np
import pytest
from painted_parts import BLACK, BLUE, GREEN, GREY, RED, WHITE, cube, rod

from workbench.model.scan import ALL_KINDS, Objection
from workbench.perception.matching.pose_error import pose_error
from workbench.perception.simulation.colouring import Light
from workbench.perception.simulation.piles import drop_parts, pile_of
from workbench.perception.simulation.synthesize import synthesize
from workbench.plugins.localizer import find_parts

WARM = Light(np.array([1.15, 1.0, 0.85]) * 0.6)
COLD = Light(np.array([0.9, 1.0, 1.15]) * 1.3, ambient=0.5, noise=0.01)


def pairs(cell, truth, found):
    """Each part found with the one that lies there."""
    middles = np.array([one.T_world_part.act(cell.part(one.part).mesh.middle) for one in truth])
    for one in found:
        off = np.linalg.norm(
            middles - one.T_world_part.act(cell.part(one.part).mesh.middle), axis=1
        )
        assert off.min() < 0.003
        yield one, truth[int(off.argmin())]


def up(one) -> np.ndarray:
    return one.T_world_part.rotation[:, 2]


@pytest.mark.parametrize("light", [Light(), WARM, COLD], ids=["even", "warm", "cold"])
def test_kinds_of_one_shape_are_told_by_their_colours(cell, light):
    cell = replace(cell, parts=(rod(RED, RED, "red"), rod(BLUE, BLUE, "blue")))
    truth = drop_parts(cell.parts * 3, cell.bin, seed=21)
    found = find_parts(synthesize(cell, truth, seed=21, light=light), cell, seed=0)
    assert len(found.detections) == len(truth)
    for one, true in pairs(cell, truth, found.detections):
        assert (one.part, one.by_colour) == (true.part, True)
    assert Objection.COLOURS in {one.reason for one in found.rejected}


def test_black_and_white_are_told_where_both_are_seen(cell):
    cell = replace(cell, parts=(rod(WHITE, WHITE, "white"), rod(BLACK, BLACK, "black")))
    truth = drop_parts(cell.parts * 2, cell.bin, seed=22)
    found = find_parts(synthesize(cell, truth, seed=22, light=WARM), cell, seed=0).detections
    assert len(found) == len(truth)
    assert all(
        (one.part, one.by_colour) == (true.part, True) for one, true in pairs(cell, truth, found)
    )


def test_of_black_alone_nobody_knows_whether_it_is_white_in_the_dark(cell):
    white, black = rod(WHITE, WHITE, "white"), rod(BLACK, BLACK, "black")
    cell = replace(cell, parts=(white, black))
    truth = drop_parts((white,) * 2, cell.bin, seed=23)
    dim = Light(np.full(3, 0.2))
    found = find_parts(synthesize(cell, truth, seed=23, light=dim), cell, seed=0).detections
    assert len(found) == len(truth)
    assert all(one.by_colour is False for one in found)


@pytest.mark.parametrize("light", [Light(), WARM, COLD], ids=["even", "warm", "cold"])
def test_which_end_is_painted_is_told_of_a_rod(cell, light):
    kind = rod(RED, GREY)
    cell = replace(cell, parts=(kind,))
    truth = drop_parts((kind,) * 4, cell.bin, seed=24)
    scan = synthesize(cell, truth, seed=24, light=light)
    found = find_parts(scan, cell, seed=0).detections
    assert len(found) == len(truth)
    for one, true in pairs(cell, truth, found):
        assert one.by_colour is True
        assert up(one) @ up(true) > 0.99
        far, turn = pose_error(kind, true.T_world_part, one.T_world_part)
        assert far < 0.002 and turn < np.deg2rad(3.0), "it moved while it was turned"


def test_without_colours_in_the_scan_it_is_by_shape_alone(cell):
    kind = rod(RED, GREY)
    cell = replace(cell, parts=(kind,))
    truth = drop_parts((kind,) * 3, cell.bin, seed=24)
    scan = replace(synthesize(cell, truth, seed=24), colours=None)
    found = find_parts(scan, cell, seed=0).detections
    assert len(found) == len(truth)
    assert all(one.by_colour is False for one in found)
    plain = replace(cell, parts=(replace(kind, colours=None),))
    alone = find_parts(scan, plain, seed=0).detections
    assert [one.T_world_part for one in alone] == [one.T_world_part for one in found]
    assert all(one.by_colour is None for one in alone)


def test_colours_of_something_else_decide_nothing(cell):
    kind = rod(RED, GREY)
    cell, other = replace(cell, parts=(kind,)), replace(cell, parts=(rod(GREEN, GREEN),))
    truth = drop_parts(other.parts * 3, cell.bin, seed=25)
    found = find_parts(synthesize(other, truth, seed=25), cell, seed=0).detections
    assert len(found) == len(truth)
    assert all(one.by_colour is False for one in found)


def test_noise_that_drowns_colours_decides_nothing(cell):
    kind = rod((150, 120, 120), GREY)
    cell = replace(cell, parts=(kind,))
    truth = drop_parts((kind,) * 3, cell.bin, seed=26)
    rough = Light(np.full(3, 0.3), noise=0.2)
    found = find_parts(synthesize(cell, truth, seed=26, light=rough), cell, seed=0).detections
    assert len(found) == len(truth)
    assert not any(one.by_colour for one in found)


@pytest.mark.parametrize("is_stated", [True, False])
def test_a_marked_face_of_a_cube_is_told_where_it_is_seen_and_only_there(cell, is_stated):
    kind = cube(BLUE, is_stated=is_stated)
    cell = replace(cell, parts=(kind,))
    seen = 0
    for seed in (27, 28):
        truth = pile_of(cell, ALL_KINDS, 5, seed=seed)
        found = find_parts(synthesize(cell, truth, seed=seed, light=WARM), cell, seed=0).detections
        for one, true in pairs(cell, truth, found):
            seen += bool(one.by_colour)
            if one.by_colour:
                assert up(one) @ up(true) > 0.99
            else:
                assert up(true)[2] < 0.9, "its mark is on top, in plain view"
                assert up(one)[2] < 0.9, "nothing is marked there"
    assert seen, "chance turns one of ten up that way"


def test_parts_that_shape_tells_are_not_asked_of_their_colours(cell, part):
    red = replace(part, colours=np.tile(RED, (len(part.mesh.triangles), 1)))
    cell = replace(cell, parts=(red,))
    truth = drop_parts((red,) * 2, cell.bin, seed=29)
    scan = synthesize(cell, truth, seed=29)
    found = find_parts(scan, cell, seed=0).detections
    plain = find_parts(scan, replace(cell, parts=(part,)), seed=0).detections
    assert [one.T_world_part for one in found] == [one.T_world_part for one in plain]
    assert all(one.by_colour is None for one in found)
