"""Piles of which parts are taken over a station: two plans, and one part taken."""

from collections import namedtuple
from dataclasses import replace

import numpy as np

from workbench.app.emptying import carrying
from workbench.app.emptying.empty import _failures_in_a_row, empty_pile
from workbench.app.emptying.film import Film
from workbench.formats.cells.reading import read_cell
from workbench.formats.files.shipped import find
from workbench.gui.emptying.reel import end_of, moment_of, reel_of
from workbench.gui.shared.own import Showing
from workbench.model.geometry import pose_from_rpy
from workbench.model.prediction import PileTask
from workbench.model.scan import Detection
from workbench.planning.kinematics.robot import Kinematics

CELL = read_cell(find("robots", "yumi") / "regrasp.toml")
TASK = PileTask("regrasp", "", 1, 3)


def lying() -> Detection:
    at = CELL.bin.T_world_bin.translation + np.array([0.03, -0.05, 0.0191])
    return Detection("keyed_cylinder", pose_from_rpy(at, (np.pi / 2, 0.0, 0.4)))


def test_a_part_that_goes_over_the_post_is_taken_once_and_shown_there_between_both_plans():
    shots = []
    pile = empty_pile(CELL, TASK, (lying(),), film=shots.append)
    assert (pile.taken, pile.left, sum(pile.failed)) == (1, (), 0)
    first, second = shots
    assert (first.plan.stations, second.plan.stations) == (("post",), ())
    assert [pick.is_taken for shot in shots for pick in shot.picks] == [False, True]
    ((number, standing),) = second.before
    post = CELL.T_world_station(CELL.stations[0]).translation
    assert number == 0 and np.linalg.norm((standing.T_world_part.translation - post)[:2]) < 0.02
    assert second.after == ()
    film = Film(TASK, ((0, lying()),), tuple(shots), ())
    reel = reel_of(film)
    showing = Showing(film, reel.seconds, {}, reel.stretches[1].start + 0.01, is_playing=False)
    (part,) = moment_of(CELL, Kinematics(CELL), reel, showing).parts
    assert np.allclose(part.T_world_part.homogeneous, standing.T_world_part.homogeneous)
    assert end_of(reel) > reel.stretches[1].start


def test_a_part_that_the_hand_misses_on_the_post_counts_as_failed_and_stays_nowhere(monkeypatch):
    taken = carrying.carried_out

    def missed_on_the_post(cell, truth, arm_plan, meant):
        found = taken(cell, truth, arm_plan, meant)
        return found if arm_plan.station else replace(found, number=None, is_straight=False)

    monkeypatch.setattr(carrying, "carried_out", missed_on_the_post)
    shots = []
    pile = empty_pile(CELL, TASK, (lying(),), film=shots.append)
    assert (pile.taken, sum(pile.failed), pile.knocked_out, pile.left) == (0, 1, 1, ())
    assert shots[-1].after == ()


def test_a_part_put_on_the_post_does_not_end_failures_in_a_row():
    plan = namedtuple("Plan", "arms stations")
    over, direct = plan((1,), ("post",)), plan((1,), ())
    assert _failures_in_a_row(2, over, []) == 2
    assert _failures_in_a_row(2, direct, []) == 0
    assert _failures_in_a_row(2, direct, [0]) == 3
