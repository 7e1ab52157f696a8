"""A film of an emptied pile: what is where at each of its moments."""

from dataclasses import replace

import numpy as np
import pytest
from made_films import film_of

from workbench.app.emptying.film import Film
from workbench.app.emptying.stirring import stir_pile
from workbench.gui.emptying.reel import LOOK_SHOWN_FOR, Projector, advance, end_of, reel_of
from workbench.gui.shared.own import Showing
from workbench.model.digest import digest_of
from workbench.model.prediction import PileTask
from workbench.model.scan import Scene
from workbench.perception.simulation.piles import pile_of
from workbench.planning.kinematics.robot import Kinematics


@pytest.fixture(scope="module")
def kinematics(cell):
    return Kinematics(cell)


@pytest.fixture(scope="module")
def film(cell, result, detections):
    return film_of(cell, result.plan, detections)


def moment(cell, film, time: float, **about):
    showing = Showing(film, reel_of(film).seconds, {2: "tool collision"}, time, **about)
    return Projector().moment(cell, showing)


def places(found) -> dict[int, np.ndarray]:
    return {part.number: part.T_world_part.translation for part in found.parts}


def test_it_begins_with_a_look_at_the_pile_as_it_fell_and_the_robot_at_home(cell, film):
    found = moment(cell, film, 0.0)
    for number, one in film.fallen:
        np.testing.assert_allclose(places(found)[number], one.T_world_part.translation)
    assert all(np.array_equal(found.arms[arm.name].q, arm.home) for arm in cell.arms)
    assert "Plan 1 of 1, 0 of 4 taken: scan of the bin" in str(found.says)


def test_a_part_goes_with_the_hand_and_stays_where_that_lets_go_of_it(cell, kinematics, film):
    reel = reel_of(film)
    (shot,), (stretch,) = film.shots, reel.stretches
    pick = shot.picks[0]
    runs = {run.leg.name: run for run in stretch.runs if run.arm == pick.arm}
    lies = dict(film.fallen)[pick.number].T_world_part.translation
    just_before = moment(cell, film, LOOK_SHOWN_FOR + runs["extract"].start - 1e-3)
    np.testing.assert_allclose(places(just_before)[pick.number], lies, atol=1e-6)
    middle = LOOK_SHOWN_FOR + (runs["return"].start + runs["return"].end) / 2
    found = moment(cell, film, middle)
    held = kinematics.tcp_pose(cell.arm(pick.arm), found.arms[pick.arm].q) * pick.T_tcp_part
    np.testing.assert_allclose(places(found)[pick.number], held.translation, atol=1e-9)
    assert np.linalg.norm(places(found)[pick.number] - lies) > 0.05
    put = kinematics.tcp_pose(cell.arm(pick.arm), runs["place"].leg.q[-1]) * pick.T_tcp_part
    last = moment(cell, film, stretch.end - 1e-3)
    np.testing.assert_allclose(places(last)[pick.number], put.translation, atol=1e-9)
    assert "2 of 4 taken" in str(last.says)


def test_what_lies_beside_moves_only_while_a_part_is_lifted(cell, film):
    reel = reel_of(film)
    pick = film.shots[0].picks[0]
    lift = next(run for run in reel.stretches[0].runs
                if run.arm == pick.arm and run.leg.name == "extract")  # fmt: skip
    before, after = places(moment(cell, film, 0.0))[2], dict(pick.after)[2].T_world_part.translation
    half = places(moment(cell, film, LOOK_SHOWN_FOR + (lift.start + lift.end) / 2))
    np.testing.assert_allclose(half[2], (before + after) / 2, atol=1e-6)
    assert 3 in half, "it is still falling"
    over = places(moment(cell, film, LOOK_SHOWN_FOR + lift.end + 1e-6))
    np.testing.assert_allclose(over[2], after, atol=1e-9)
    assert 3 not in over


def test_at_the_end_stands_what_stays_with_its_reason(cell, film):
    reel = reel_of(film)
    for time in (end_of(reel), reel.seconds, reel.seconds + 100.0):
        found = moment(cell, film, time)
        assert [(part.number, part.kind) for part in found.parts] == [(2, "tool collision")]
        assert str(found.says) == "The end: 2 of 4 taken, 1 left"
    assert not any(part.kind for part in moment(cell, film, end_of(reel) - 1e-3).parts)


def test_a_pile_of_which_nothing_is_taken_has_a_film_too(cell, film):
    bare = Film(film.task, film.fallen, (), film.fallen)
    found = moment(cell, bare, 0.0)
    assert len(found.parts) == 4 and str(found.says) == "The end: 0 of 4 taken, 4 left"
    assert end_of(reel_of(bare)) == 0.0


def test_a_pick_that_misses_moves_no_part_and_says_so(cell, film):
    shot = film.shots[0]
    missed = tuple(replace(pick, number=None, outcome="missed", after=shot.before)
                   for pick in shot.picks)  # fmt: skip
    other = Film(film.task, film.fallen, (replace(shot, picks=missed),), film.fallen)
    found = moment(cell, other, end_of(reel_of(other)) - 1e-3)
    for number, one in film.fallen:
        np.testing.assert_allclose(places(found)[number], one.T_world_part.translation)
    assert "closes on nothing: missed" in str(found.says) and "0 of 4 taken" in str(found.says)


def test_it_plays_as_fast_as_wanted_and_stops_at_its_end(film):
    showing = Showing(film, 10.0, {}, 2.0, is_playing=True, speed=4.0)
    assert advance(showing, 0.5).time == pytest.approx(4.0)
    over = advance(showing, 5.0)
    assert (over.time, over.is_playing) == (10.0, False)
    paused = replace(showing, is_playing=False)
    assert advance(paused, 5.0) is paused


def test_stirred_parts_go_from_waypoint_to_waypoint(cell):
    pile = pile_of(cell, "", 3, seed=5)
    shot = stir_pile(cell, tuple(enumerate(pile)), Scene(digest_of(pile), pile), seed=0)
    assert shot is not None
    film = Film(PileTask(cell.name, "", 3, 5), shot.before, (shot,), shot.after)
    (stretch,) = reel_of(film).stretches
    run = next(run for run in stretch.runs if run.leg.name == "stir")
    k = len(run.leg.t) // 2
    for time, frame in ((0.0, shot.before), (run.start + run.leg.t[k], shot.stirred[k])):
        found = moment(cell, film, LOOK_SHOWN_FOR + time)
        for number, detection in frame:
            np.testing.assert_allclose(
                places(found)[number], detection.T_world_part.translation, atol=1e-6
            )
    found = moment(cell, film, LOOK_SHOWN_FOR + run.end)
    assert {part.number for part in found.parts} == {k for k, _ in shot.after}
    assert "arm stirs the parts" in str(found.says)
