"""A film of an emptied pile: in one browser alone, and over when something real begins."""

from dataclasses import replace

import numpy as np
import pytest
from made_films import filmed_of
from waiting import wait_until

from workbench.app.core.cell.changes import ChangeCell
from workbench.app.core.cell.emptying import TryEmptying
from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.jobs import JobEnded
from workbench.app.core.cycle.scanning import TakeScan, UseScan
from workbench.app.core.cycle.sending import SendPlan
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.core.people import Person, Role
from workbench.app.core.state import Phase
from workbench.app.runtime.live import Live
from workbench.gui.drawing.film_scene import REAL, FilmScene
from workbench.gui.emptying.panel import EmptyingPanel
from workbench.gui.shared.movable_frames import BIN, move_frame
from workbench.model.geometry import pose_from_rpy


@pytest.fixture
def emptied(planned, cell, result, detections):
    """Piles that were emptied, whose films the worker has brought."""
    filmed = filmed_of(cell, result.plan, detections)
    number = planned.do(TryEmptying(count=4, piles=2), "Anna").number
    planned._effects.live = Live(films=filmed)
    planned.do(JobEnded(number, filmed.emptying), "worker")
    return planned


def film(hands):
    return hands.panel(EmptyingPanel)._film


def node(hands, name):
    return hands.visitor.client.scene.get_handle_by_name(name)


def has_ended(hands) -> bool:
    return hands.visitor.own.now.film is None and node(hands, "/film") is None


def test_the_parts_move_in_that_browser_alone_in_place_of_what_is_there(page, emptied, sit_down):
    ada, bob = sit_down(), sit_down()
    film(ada)._play_or_pause()
    wait_until(lambda: node(ada, "/film/part-1") is not None, "the first part")
    began = np.array(node(ada, "/film/part-1").position)
    assert all(node(ada, name).visible is False for name in REAL)
    wait_until(
        lambda: (
            (part := node(ada, "/film/part-1")) is not None
            and np.linalg.norm(np.array(part.position) - began) > 0.05
        ),
        "the part in the hand",
    )
    assert ada.link is not None, "the robot moves along"
    assert node(bob, "/film") is None and bob.link is None
    assert page._renderer._server.scene.get_handle_by_name("/film/part-1") is None
    assert page._renderer._server.scene.get_handle_by_name("/parts/part-1") is not None
    ada.visitor.own.change(film=None)
    wait_until(lambda: node(ada, "/film") is None and ada.link is None, "the end of the film")
    wait_until(lambda: all(node(ada, name) is None for name in REAL), "what is there again")


def test_what_stays_is_coloured_and_a_click_on_its_row_names_it(emptied, sit_down):
    ada = sit_down()
    film(ada)._go_to_end()
    wait_until(lambda: node(ada, "/film/part-3/label") is not None, "the part that stays")
    assert node(ada, "/film/part-1") is None and node(ada, "/film/part-3/label").text == "3"
    assert ada.visitor.own.now.film.is_playing is False
    ada.panel(EmptyingPanel)._choose_part(0)
    wait_until(
        lambda: (
            (label := node(ada, "/film/part-3/label")) is not None
            and label.text == "part-3: tool collision"
        ),
        "the reason",
    )
    wait_until(lambda: "wb-chosen" in film(ada)._left.content, "the row that is marked")


def test_a_click_on_a_part_in_the_scene_marks_its_row(emptied, sit_down):
    ada = sit_down()
    film(ada)._go_to_end()
    wait_until(lambda: node(ada, "/film/part-3/mesh") is not None, "the part that stays")
    assert node(ada, "/film/part-3/mesh")._impl.click_cb, "it can be clicked"
    ada.panel(FilmScene)._on_pressed(2, None)
    assert ada.visitor.own.now.film.chosen == 2
    wait_until(lambda: "wb-chosen" in film(ada)._left.content, "the row that is marked")


def test_another_pile_goes_on_with_its_own_film(emptied, sit_down):
    ada = sit_down()
    film(ada)._play_or_pause()
    ada.panel(EmptyingPanel)._choose(1)
    showing = ada.visitor.own.now.film
    assert showing.film.task.seed == 1 and showing.is_playing
    film(ada)._go_to(0.5)
    showing = ada.visitor.own.now.film
    assert (showing.time, showing.is_playing) == (0.5, False)
    film(ada)._go_to(float("1e9"))
    assert ada.visitor.own.now.film.time == showing.seconds


@pytest.mark.parametrize("what", ["play", "send", "scan", "task", "cell", "jog", "piles"])
def test_it_ends_when_something_real_begins_or_other_piles_come(emptied, sit_down, scan, what):
    bench, ada = emptied, sit_down()
    film(ada)._play_or_pause()
    wait_until(lambda: node(ada, "/film/part-1") is not None, "the film")
    match what:
        case "play":
            ada.play()
        case "send":
            bench.do(WatchPlan(bench.state.plan.digest), "Anna")
            bench.do(Approve(bench.state.plan.digest), "Anna")
            wait_until(lambda: has_ended(ada), "the end of the film, with the approval")
            film(ada)._play_or_pause()
            bench.do(SendPlan(bench.state.plan.digest), "Anna")
            assert bench.state.phase is Phase.SENDING
        case "scan":
            bench.do(UseScan(replace(scan, at=scan.at + 1.0)), "Anna")
        case "task":
            number = bench.do(TakeScan(), "Anna").number
            assert ada.visitor.own.now.film is not None, "nothing has come of it yet"
            bench.do(JobEnded(number, replace(scan, at=scan.at + 2.0)), "worker")
        case "cell":
            T = bench.state.cell.bin.T_world_bin * pose_from_rpy((0.01, 0, 0), (0, 0, 0))
            bench.do(ChangeCell(move_frame(bench.state.cell, BIN, T), "the bin is moved"), "Anna")
        case "jog":
            ada.jog()
        case "piles":
            number = bench.do(TryEmptying(count=4, piles=1), "Anna").number
            found = bench.state.emptying
            other = replace(found, piles=found.piles[:1])
            bench.do(JobEnded(number, other), "worker")
    wait_until(lambda: has_ended(ada), "the end of the film")


def test_who_only_follows_may_look_at_it_all_the_same(emptied, sit_down):
    ada = sit_down()
    ada.visitor.person = Person("Vic", Role.VIEWER)
    film(ada)._play_or_pause()
    wait_until(lambda: node(ada, "/film/part-1") is not None, "the film")
    time = ada.visitor.own.now.film.time
    wait_until(lambda: ada.visitor.own.now.film.time > time, "it goes on")


@pytest.mark.parametrize("why", ["restart", "cell"])
def test_without_a_film_of_this_cell_none_is_shown_and_it_is_said_why(emptied, sit_down, why):
    bench = emptied
    if why == "restart":
        bench._effects.live = Live()
    else:
        T = bench.state.cell.bin.T_world_bin * pose_from_rpy((0.01, 0, 0), (0, 0, 0))
        bench.do(ChangeCell(move_frame(bench.state.cell, BIN, T), "the bin is moved"), "Anna")
    ada = sit_down()
    assert film(ada)._play.disabled
    said = {"restart": "the same seed empties the same piles again", "cell": "has changed since"}
    assert said[why] in film(ada)._play.hint
    film(ada)._play_or_pause()
    assert ada.visitor.own.now.film is None
    assert "Taken" in ada.panel(EmptyingPanel)._summary.content, "the table is there"
