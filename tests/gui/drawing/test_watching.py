"""The server sees before whose eyes a plan was played to its end, drawn all the way.

Skipping with the scrubber does not count, nor what a browser does not draw, nor a robot that stands
elsewhere there because somebody moves it by hand.
"""

import time
from dataclasses import replace

import numpy as np
import pytest
from waiting import PATIENCE, wait_until

from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.sending import SendPlan
from workbench.app.core.state import Phase
from workbench.app.runtime.live import Live
from workbench.gui.calibration.panel import CalibrationPanel
from workbench.gui.cell.panel import CellPanel
from workbench.gui.cycle.panel import CyclePanel
from workbench.gui.drawing.audience import LONGEST_GAP
from workbench.gui.drawing.in_view import HandWays, are_seen
from workbench.gui.drawing.own_scene import OwnScene
from workbench.gui.grasps.panel import GraspsPanel
from workbench.gui.page.modes import mode_html
from workbench.gui.shared.playback import joint_values, moments
from workbench.model.errors import CommandRefused
from workbench.planning.kinematics.robot import Kinematics


def shared_link(page, root="/planned"):
    cell = page._renderer._bench.state.cell
    node = page._renderer._server.scene.get_handle_by_name(f"{root}/{cell.arms[0].flange}")
    return np.array(node.position)


def planned_link(page, look):
    cell, runs = page._renderer._bench.state.cell, page._renderer._runs
    values = joint_values(cell, moments(cell, runs, look.time))
    return Kinematics(cell).link_poses(values)[cell.arms[0].flange].translation


def follows_the_plan(page):
    planned = planned_link(page, page._renderer._look.now)
    # Where the plan ends at home, as the robot stands, one robot is shown and not two.
    is_two = page._renderer._server.scene.get_handle_by_name("/planned").visible
    return np.allclose(shared_link(page, "/planned" if is_two else "/robot"), planned, atol=1e-6)


def test_a_plan_that_was_skipped_through_was_not_watched(page, planned, sit_down):
    bench, hands = planned, sit_down()
    look = page._renderer._look
    end = bench.state.plan.cycle_seconds

    def played_from(start: float) -> None:
        time.sleep(0.5)
        look.change(time=start, is_playing=True, by=None, browser=hands.number)
        wait_until(lambda: not look.now.is_playing, "the end of the plan")

    played_from(end - 0.5)
    time.sleep(0.5)
    assert bench.state.watched == ()
    played_from(0.0)
    bench.wait(lambda state: state.watched != (), PATIENCE)
    assert bench.state.watched == ("operator",)
    # No more than 1 s apart: docs/safety.md promises it.
    assert hands.browser.drawn > end / LONGEST_GAP and LONGEST_GAP <= 1.0


def test_what_plays_faster_than_the_robot_moves_was_not_watched(page, planned, sit_down):
    hands, look = sit_down(), page._renderer._look
    look.change(speed=4.0)
    hands.play()
    wait_until(lambda: look.now.time >= planned.state.plan.cycle_seconds, "the end of the plan")
    time.sleep(0.5)
    assert planned.state.watched == ()
    look.change(speed=1.0)
    hands.play()
    planned.wait(lambda state: state.watched != (), PATIENCE)


def test_a_loop_begins_again_until_somebody_pauses(page, planned, sit_down):
    hands, look = sit_down(), page._renderer._look
    look.change(loops=True, speed=4.0)
    hands.play()
    for _ in range(2):
        wait_until(lambda: look.now.time > planned.state.plan.cycle_seconds / 2, "the second half")
        wait_until(lambda: look.now.time < planned.state.plan.cycle_seconds / 2, "the first half")
    assert look.now.is_playing
    hands.play()
    assert not look.now.is_playing


def test_what_plays_before_nobody_was_not_watched(page, planned):
    look = page._renderer._look
    wait_until(lambda: page._renderer._drawn is not None, "the first drawing")
    look.change(time=0.0, is_playing=True, by=None)
    wait_until(lambda: not look.now.is_playing, "the end of the plan")
    time.sleep(1.0)
    assert planned.state.watched == ()


def test_a_browser_that_does_not_draw_holds_the_plan_and_has_not_watched(page, planned, sit_down):
    hands, look = sit_down(), page._renderer._look
    hands.play()
    wait_until(lambda: look.now.time > LONGEST_GAP, "the plan to play")
    hands.browser.is_in_front = False
    wait_until(lambda: hands.renderer._player._audience._drawn >= look.now.time, "a drawing")
    drawn = hands.browser.drawn

    def stands() -> bool:
        at = look.now.time
        time.sleep(2 * LONGEST_GAP)
        return look.now.time == at

    wait_until(stands, "the plan to be held")
    assert look.now.time < planned.state.plan.cycle_seconds
    assert hands.browser.drawn <= drawn + 1
    assert look.now.is_playing and planned.state.watched == ()
    # In front again it goes on where it was, and all of it was seen.
    hands.browser.is_in_front = True
    planned.wait(lambda state: state.watched != (), PATIENCE)
    assert planned.state.watched == ("operator",)


def test_a_browser_that_leaves_stops_the_plan(page, planned, sit_down):
    hands, look = sit_down(), page._renderer._look
    sit_down()
    hands.play()
    wait_until(lambda: look.now.time > LONGEST_GAP, "the plan to play")
    hands.browser.leave()
    wait_until(lambda: not look.now.is_playing, "the end of playing")
    assert look.now.time < planned.state.plan.cycle_seconds
    assert planned.state.watched == ()


def test_playing_ends_every_jog_and_the_robot_follows_the_plan_in_all_browsers(
    page, planned, sit_down
):
    ada, bob, look = sit_down(), sit_down(), page._renderer._look
    ada.jog()
    # As somebody does who has a pose suggested, and logs out.
    bob.panel(CalibrationPanel)._suggest_next()
    wait_until(lambda: ada.link is not None and bob.link is not None, "the jogged robots")
    wait_until(lambda: not np.allclose(bob.link, shared_link(page)), "the pose suggested to Bob")
    ada.play()
    wait_until(lambda: look.now.time > LONGEST_GAP, "the plan to play")
    wait_until(lambda: ada.link is None and bob.link is None, "the end of the jogs")
    assert not ada.is_jogged and not bob.is_jogged
    planned.wait(lambda state: state.watched != (), PATIENCE)
    wait_until(lambda: follows_the_plan(page), "the robot at the end of the plan")
    assert planned.state.watched == ("operator",)


def test_a_jog_is_seen_by_nobody_else_and_goes_with_its_browser(page, planned, sit_down):
    ada, bob = sit_down(), sit_down()
    wait_until(lambda: page._renderer._drawn is not None, "the first drawing")
    before = shared_link(page)
    ada.jog()
    ada.panel(CellPanel)._jog._move(np.asarray(planned.state.cell.arms[0].home) + 0.2)
    wait_until(lambda: ada.link is not None and not np.allclose(ada.link, before), "the jog")
    assert bob.link is None and not bob.is_jogged
    assert np.array_equal(shared_link(page), before)
    ada.browser.leave()
    wait_until(lambda: ada.number not in page._renderer._visitors, "the end of the browser")
    bob.play()
    planned.wait(lambda state: state.watched != (), PATIENCE)
    wait_until(lambda: follows_the_plan(page), "the robot at the end of the plan")


@pytest.mark.parametrize("turned", ["jog", "stage"])
def test_who_turns_to_something_else_meanwhile_has_not_watched(page, planned, sit_down, turned):
    hands, look = sit_down(), page._renderer._look
    hands.play()
    wait_until(lambda: look.now.time > LONGEST_GAP, "the plan to play")
    if turned == "jog":
        hands.jog()
    else:
        hands.panel(GraspsPanel)._turn()
    wait_until(lambda: not look.now.is_playing, "the end of playing")
    assert look.now.time < planned.state.plan.cycle_seconds
    # A jog that comes around the controls stops it, too.
    hands.play()
    wait_until(lambda: look.now.is_playing, "the plan to play on")
    hands.visitor.own.change(jog={arm.name: arm.home for arm in planned.state.cell.arms})
    wait_until(lambda: not look.now.is_playing or not hands.is_jogged, "the end of one of both")
    hands.visitor.own.change(jog={arm.name: arm.home for arm in planned.state.cell.arms})
    wait_until(lambda: not look.now.is_playing, "the end of playing")
    assert planned.state.watched == ()


def test_while_a_plan_is_sent_the_robot_is_drawn_as_it_stands(page, planned, sit_down):
    hands, bench = sit_down(), planned
    hands.play()
    bench.wait(lambda state: state.watched != (), PATIENCE)
    bench.do(Approve(bench.state.plan.digest), "Anna")
    hands.jog()
    wait_until(lambda: hands.link is not None, "the jogged robot")
    bench.do(SendPlan(bench.state.plan.digest), "Anna")
    assert bench.state.phase is Phase.SENDING
    wait_until(lambda: hands.link is None, "the end of the jog")
    # Also one that somebody begins while the robot moves.
    hands.jog()
    wait_until(lambda: not hands.is_jogged and hands.link is None, "the end of the next jog")
    runs, cell = page._renderer._runs, bench.state.cell
    there = joint_values(cell, moments(cell, runs, 0.4))
    bench._effects.live = replace(Live(), joints=there)
    page._renderer._woken.set()
    expected = Kinematics(cell).link_poses(there)[cell.arms[0].flange].translation
    wait_until(
        lambda: np.linalg.norm(shared_link(page, "/robot") - expected) < 0.02, "the robot as it is"
    )


def test_points_that_one_measures_between_are_in_that_browser_alone(page, sit_down):
    ada, bob = sit_down(), sit_down()
    ada.visitor.own.change(measured=(np.zeros(3), np.ones(3)))
    scene = ada.visitor.client.scene
    wait_until(lambda: scene.get_handle_by_name("/measured/line") is not None, "the line")
    assert bob.visitor.client.scene.get_handle_by_name("/measured/line") is None
    assert page._renderer._server.scene.get_handle_by_name("/measured/line") is None
    assert isinstance(ada.panel(OwnScene), OwnScene)


SKY = (0.0, -3.0, 1.0), (0.1, -3.0, 9.0)
"""A camera that looks up."""


def test_playing_brings_the_camera_to_where_the_hands_and_the_bin_are_seen(page, planned, sit_down):
    hands, cell = sit_down(), planned.state.cell
    hands.browser.look(*SKY)
    time.sleep(0.5)
    hands.play()
    planned.wait(lambda state: state.watched != (), PATIENCE)
    camera = hands.visitor.client.camera
    way = HandWays(cell, Kinematics(cell), page._renderer._runs)
    end = page._renderer._drawn.plan_seconds
    assert are_seen(camera, way.along(((0.0, end),)))
    assert are_seen(camera, cell.bin.T_world_bin.translation[None])
    # Who has seen it may look as closely as they like.
    close = hands.browser.looks_from * 0.3
    hands.browser.look(close, cell.bin.T_world_bin.translation)
    wait_until(lambda: np.allclose(camera.position, close), "the camera")
    look = page._renderer._look
    hands.play()
    wait_until(lambda: look.now.time > 1.0 and look.now.is_playing, "the plan to play")
    assert np.allclose(hands.visitor.client.camera.position, close)


def test_what_plays_with_the_hands_out_of_the_picture_was_not_watched(page, planned, sit_down):
    hands, look = sit_down(), page._renderer._look
    hands.play()
    wait_until(lambda: look.now.time > 1.0, "the plan to play")
    seen = hands.browser.looks_from, hands.browser.looks_at
    hands.browser.look(*SKY)
    wait_until(lambda: bool(page._renderer._drawn.hidden), "the hands to be out of the picture")
    assert "does not count as watched" in mode_html(page._renderer._drawn)
    wait_until(lambda: look.now.time > 3.0, "the plan to play")
    hands.browser.look(*seen)
    wait_until(lambda: not look.now.is_playing, "the end of the plan")
    ((begin, end),) = page._renderer._drawn.hidden
    wait_until(lambda: page._renderer._drawn.unseen == ((begin, end),), "all else to be drawn")
    assert 0.9 < begin < 3.0 < end < page._renderer._drawn.plan_seconds
    words = f"The grippers were out of view from {begin:.1f} s to {end:.1f} s; play that part again"
    wait_until(lambda: words in mode_html(page._renderer._drawn), "what has to be played")
    assert planned.state.watched == ()
    with pytest.raises(CommandRefused, match="has not been played to its end"):
        planned.do(Approve(planned.state.plan.digest), "Ada")
    line = hands.panel(CyclePanel)._approval_line
    wait_until(lambda: words in line.content, "what the tab says of it")
    # Play begins with that part, and it is enough.
    hands.play()
    wait_until(lambda: look.now.is_playing and look.now.time < end, "the plan to play")
    assert look.now.time >= begin
    planned.wait(lambda state: state.watched != (), PATIENCE)
    assert look.now.time < page._renderer._drawn.plan_seconds
