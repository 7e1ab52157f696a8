"""Verdicts while something is dragged: whose they are, which one is shown, and when they end."""

import asyncio
import threading
from dataclasses import replace
from types import SimpleNamespace

import msgspec
import numpy as np
import pinocchio as pin
import pytest
from idle import Idle
from raw_browser import raw_browser
from waiting import wait_until

from workbench.app.core.cell.changes import ChangeCell
from workbench.app.core.control import TakeControl
from workbench.app.core.cycle.parts import UseDetections
from workbench.app.core.cycle.scanning import TakeScan
from workbench.app.core.people import Role
from workbench.app.picking.glance import Glance
from workbench.app.runtime.bench import Bench
from workbench.gui.cell.panel import CellPanel
from workbench.gui.dragging.verdicts import LiveVerdicts
from workbench.gui.dragging.views import VerdictRoom, dragged_html
from workbench.gui.page.server import serve
from workbench.gui.scene.drag_overlay import _corners_around, live_message, right_of
from workbench.gui.scene.surroundings import FIELD_OF_VIEW, first_look, nodes_with
from workbench.gui.shared.movable_frames import moving
from workbench.gui.shared.own import Dragged
from workbench.journal.journal import Journal
from workbench.model.candidate import Reason
from workbench.model.errors import WorkbenchError
from workbench.model.part import Region

HERE = pin.SE3.Identity()


def glance(working: int, of: int = 4, apart: int = 0) -> Glance:
    """So many of as many candidates work, the others meet something, some without touching it."""
    reasons = (Reason.OK,) * working + (Reason.TOOL_COLLISION,) * (of - working)
    is_apart = np.arange(of) >= of - apart
    zeros, up = np.zeros((of, 3)), np.tile([0.0, 0.0, 1.0], (of, 1))
    names = ("side",) * of, ("right",) * of
    return Glance(np.zeros(of, int), *names, reasons, is_apart, zeros, up)


@pytest.fixture
def found(bench, detections):
    """A bench with parts found, at which nobody works anything out."""
    bench.do(UseDetections(detections), "Ada")
    return bench


@pytest.fixture
def verdicts(visitor):
    return LiveVerdicts(visitor, ChangeCell)


def asked(bench):
    return bench._effects.asked


def shown(visitor):
    return visitor.own.now.dragged


def test_what_is_dragged_is_asked_about_and_its_answer_shown(found, verdicts, visitor, cell):
    verdicts.begin()
    change = moving(cell, "bin", pin.SE3(np.eye(3), np.array([0.4, 0.0, 0.1])))
    verdicts.ask({"change": change}, HERE)
    (question,) = asked(found)
    assert question.name == "glance" and question.asker == visitor.number
    assert question.arguments["change"] is change
    assert question.arguments["detections"] is found.state.detections
    answer = glance(3)
    question.answered(answer)
    assert shown(visitor).glance is answer
    assert str(live_message(answer)).startswith("while you drag: 3 of 4 work")


def test_nothing_of_it_is_on_record_and_the_state_stays_the_same(found, verdicts, visitor):
    head, state = found.head, found.state
    verdicts.begin()
    verdicts.ask({}, HERE)
    asked(found)[0].answered(glance(1))
    assert shown(visitor) is not None
    verdicts.end()
    assert found.head == head and found.state is state


def test_an_older_answer_than_what_is_shown_is_not_shown(found, verdicts, visitor):
    verdicts.begin()
    for _ in range(3):
        verdicts.ask({}, HERE)
    first, second, third = asked(found)
    third.answered(glance(3))
    first.answered(glance(1))
    second.answered(glance(2))
    assert int(shown(visitor).glance.working.sum()) == 3


def test_with_the_drag_the_verdicts_end_and_late_answers_come_to_nothing(found, verdicts, visitor):
    verdicts.begin()
    verdicts.ask({}, HERE)
    verdicts.ask({}, HERE)
    asked(found)[0].answered(glance(1))
    verdicts.end()
    assert shown(visitor) is None
    asked(found)[1].answered(glance(2))
    assert shown(visitor) is None
    verdicts.begin()
    asked(found)[1].answered(glance(2))
    assert shown(visitor) is None, "an answer to an earlier drag"


def test_with_the_browser_the_verdicts_end(found, verdicts, visitor):
    verdicts.begin()
    verdicts.ask({}, HERE)
    visitor.end(is_gone=True)
    asked(found)[0].answered(glance(1))
    assert shown(visitor) is None
    verdicts.ask({}, HERE)
    assert len(asked(found)) == 1


def other_parts(bench):
    return UseDetections(bench.state.detections[:1])


def other_cell(bench):
    cell = bench.state.cell
    moved = pin.SE3(cell.bin.T_world_bin.rotation, cell.bin.T_world_bin.translation + 0.01)
    return ChangeCell(replace(cell, bin=replace(cell.bin, T_world_bin=moved)), "elsewhere")


@pytest.mark.parametrize("news", [other_parts, other_cell, lambda _: TakeScan()])
def test_with_another_state_the_verdicts_end_until_the_next_drag(found, verdicts, visitor, news):
    verdicts.begin()
    verdicts.ask({}, HERE)
    asked(found)[0].answered(glance(1))
    verdicts.ask({}, HERE)
    found.do(news(found), "Ada")
    asked(found)[1].answered(glance(2))
    assert shown(visitor) is None
    verdicts.ask({}, HERE)
    assert len(asked(found)) == 2, "of a scene that is no more nothing is asked"


def test_a_word_about_control_alone_ends_nothing_and_its_loss_does(found, verdicts, visitor):
    found.do(TakeControl(), "Ada", Role.ENGINEER)
    verdicts.begin()
    verdicts.ask({}, HERE)
    asked(found)[0].answered(glance(1))
    assert shown(visitor) is not None
    found.do(TakeControl(), "Eve", Role.ENGINEER)
    verdicts.ask({}, HERE)
    assert shown(visitor) is None and len(asked(found)) == 1


def test_without_parts_nothing_is_asked(bench, verdicts, visitor):
    verdicts.begin()
    verdicts.ask({}, HERE)
    assert asked(bench) == [] and shown(visitor) is None


def test_what_stands_around_is_looked_for_once_and_again_where_it_may_be_other(
    found, verdicts, detections
):
    verdicts.begin()
    verdicts.ask({}, HERE)
    scan, parts, placed, digest = asked(found)[0].arguments["around"]
    assert (scan, parts, placed) == (None, detections, ())
    assert digest == found.state.scene_digest
    asked(found)[0].answered(glance(1))
    verdicts.ask({}, HERE)
    assert asked(found)[1].arguments["obstacles"] == ()
    assert asked(found)[1].arguments["around"] is None
    found.do(other_parts(found), "Ada")
    verdicts.begin()
    verdicts.ask({}, HERE)
    assert asked(found)[2].arguments["around"] is not None


def test_before_the_first_drag_it_is_looked_around_and_nothing_shown(found, verdicts, visitor):
    verdicts.prepare()
    (question,) = asked(found)
    question.answered(glance(1))
    assert shown(visitor) is None
    verdicts.begin()
    verdicts.ask({}, HERE)
    assert asked(found)[1].arguments["obstacles"] == ()


def test_what_cannot_be_worked_out_is_not_shown_and_asked_no_more(found, verdicts, visitor, caplog):
    verdicts.begin()
    verdicts.ask({}, HERE)
    asked(found)[0].answered(WorkbenchError("no worker"))
    verdicts.ask({}, HERE)
    assert shown(visitor) is None and len(asked(found)) == 1
    assert "no worker" in caplog.text


def test_the_words_count_every_kind(states):
    html = dragged_html(Dragged(glance(1, of=6, apart=2), HERE, states.localized))
    assert "1 of 6 work" in html
    for kind, count in (("ok", 1), ("tool in collision", 3), ("too close", 2)):
        assert f"{kind} <b>{count}</b>" in html
    assert dragged_html(None) == ""


def test_there_is_room_for_the_words_before_a_drag_begins(states):
    told = dragged_html(Dragged(glance(1), HERE, states.localized))
    before, without = dragged_html(None, VerdictRoom.HINT), dragged_html(None, VerdictRoom.EMPTY)
    assert without == '<div class="wb-live"></div>'
    assert told.startswith('<div class="wb-live">') and before.startswith('<div class="wb-live">')


def test_the_words_stand_beside_bin_and_parts_as_they_are_seen(states, cell):
    dragged = Dragged(glance(1), cell.bin.T_world_bin, states.localized)
    position, target = first_look(cell)
    away = (target - position) / np.linalg.norm(target - position)
    right = np.cross(away, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)

    def across(p):
        seen = p - position
        return (seen @ right) / (seen @ away)

    covered = _corners_around(dragged)
    parts = [one.T_world_part.translation for one in states.localized.detections]
    camera = SimpleNamespace(position=position, up_direction=(0.0, 0.0, 1.0))
    words = right_of(camera, covered)
    assert across(words) > max(across(p) for p in covered) > max(across(p) for p in parts)
    # Not out of the picture.
    assert across(words) < np.tan(FIELD_OF_VIEW / 2)


@pytest.mark.parametrize("thing", ["bin", "scanner", "robot", "table", "region left"])
def test_what_is_drawn_of_a_thing_goes_where_it_is_dragged(cell, thing):
    one = Region("left", pin.SE3.Identity(), np.full(3, 0.1))
    regional = replace(cell, bin=replace(cell.bin, regions=(one,)))
    T = pin.SE3(np.eye(3), np.array([0.3, 0.1, 0.2]))
    nodes = nodes_with(regional, thing, T)
    moved_cell = replace(regional, **moving(regional, thing, T))
    for name, T_node in nodes.items():
        kind = name.split("/")[1]
        wanted = {
            "bin": moved_cell.bin.T_world_bin,
            "scanner": moved_cell.scanner.T_world_scanner,
            "robot": moved_cell.T_world_robot * regional.T_world_robot.inverse(),
            "fixtures": moved_cell.fixtures[0].T_world_fixture,
            "regions": moved_cell.bin.T_world_bin * moved_cell.bin.regions[0].T_bin_region,
        }[kind]
        np.testing.assert_allclose(T_node.homogeneous, wanted.homogeneous, atol=1e-12)
    assert nodes


class Answering(Idle):
    """Answers as a worker does that is a little busy: the newest question, from another thread."""

    def __init__(self, cell, do, now):
        super().__init__(cell, do, now)
        self.newest = None
        self.answers = 0
        self.is_closed = threading.Event()
        threading.Thread(target=self._run, daemon=True).start()

    def ask(self, question):
        self.newest = question

    def _run(self):
        while not self.is_closed.wait(0.02):
            question, self.newest = self.newest, None
            if question is not None:
                self.answers += 1
                question.answered(glance(2))

    def close(self):
        self.is_closed.set()


def message(kind: str, **fields) -> bytes:
    about = {"type": f"TransformControls{kind}Message", "name": "/cell_gizmo", "owner": "0"}
    return msgspec.msgpack.encode(about | fields)


@pytest.mark.extensive
@pytest.mark.parametrize("lets_go", [True, False])
def test_a_flood_from_one_browser_ends_in_its_own_view_and_another_sees_nothing_of_it(
    cell, detections, tmp_path, lets_go
):
    bench = Bench(cell, Journal(tmp_path), effects=Answering)
    bench.do(UseDetections(detections), "Ada")
    page = serve(bench, port=0, most_points=100)
    renderer, p = page._renderer, cell.bin.T_world_bin.translation.tolist()
    port = int(page.url.rpartition(":")[2])
    seen, before = [], bench.state

    def own(number):
        return renderer._visitors[number].own.now.dragged

    def bin_of(number):
        node = renderer._visitors[number].client.scene.get_handle_by_name("/bin")
        return None if node is None else np.array(node.position)

    def is_at(number, p) -> bool:
        shown = bin_of(number)
        return shown is not None and np.allclose(shown, p, atol=1e-5)

    def take_gizmo() -> int:
        wait_until(lambda: len(renderer._panels) == 2)
        number = min(renderer._panels)
        panel = next(one for one in renderer._panels[number] if isinstance(one, CellPanel))
        panel._inputs._turn()
        return number

    async def flood() -> None:
        async with raw_browser(port) as browser:
            await asyncio.to_thread(wait_until, lambda: len(renderer._panels) == 1)
            async with raw_browser(port):
                number = await asyncio.to_thread(take_gizmo)
                await browser.send(message("DragStart"))
                for k in range(500):
                    at = (p[0], p[1], p[2] + 0.02 + 1e-5 * k)
                    await browser.send(message("Update", wxyz=(1.0, 0, 0, 0), position=at))
                await asyncio.to_thread(wait_until, lambda: own(number) is not None)
                other = max(renderer._visitors)
                seen.append((other, renderer._visitors[other].own.now.dragged))
                # What is dragged is where the hand has it, in this browser alone.
                last = np.array(at)
                await asyncio.to_thread(wait_until, lambda: is_at(number, last))
                assert bin_of(other) is None
                assert bench.state is before, "nothing is done before somebody lets go"
                if lets_go:
                    await browser.send(message("DragEnd"))
                    await asyncio.to_thread(wait_until, lambda: bench.state is not before)
                    await asyncio.to_thread(wait_until, lambda: own(number) is None)
                    await asyncio.to_thread(wait_until, lambda: bin_of(number) is None)
                    bin = renderer._server.scene.get_handle_by_name("/bin")
                    np.testing.assert_allclose(bin.position, last, atol=1e-5)

    try:
        asyncio.run(flood())
        wait_until(lambda: not renderer._visitors)
        assert [dragged for _, dragged in seen] == [None]
        assert (bench.state is before) != lets_go
        assert bench._effects.answers < 500
    finally:
        page.close()
        bench.close()
