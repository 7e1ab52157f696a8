"""Piles of which parts are taken over a station: two plans, and one part taken."""

import numpy as np

from workbench.app.emptying.empty import empty_pile
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
