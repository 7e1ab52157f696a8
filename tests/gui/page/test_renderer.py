"""The thread that draws: nothing that cannot be worked out or drawn ends it."""

import asyncio
import logging
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from raw_browser import raw_browser
from waiting import wait_until

import workbench.gui.page.server
from workbench.app.core.cell.changes import ChangeCell
from workbench.app.core.control import TakeControl
from workbench.gui.cell.panel import CellPanel
from workbench.gui.grasps.panel import GraspsPanel
from workbench.gui.page.renderer import _needs_other_controls
from workbench.gui.page.server import serve
from workbench.gui.shared.colours import NIGHT_GRID, rgb_of
from workbench.gui.shared.look import DraggedThing
from workbench.gui.shared.viser_server import open_viser
from workbench.model.geometry import pose_from_rpy


@pytest.fixture
def page(bench):
    page = serve(bench, port=0, most_points=100)
    yield page
    page.close()


def test_what_cannot_be_worked_out_is_logged_and_the_page_goes_on(page, caplog):
    renderer = page._renderer

    def look_and_jog() -> None:
        wait_until(lambda: renderer._panels, "the controls")
        ((number, visitor),) = renderer._visitors.items()
        with caplog.at_level(logging.ERROR, "workbench.gui.page.renderer"):
            # An arm of the cell before may be jogged by a browser that has its controls still.
            visitor.own.change(jog={"no such arm": np.zeros(7)})
            wait_until(lambda: caplog.records, "the message")
        # The others go on, and so does this one.
        renderer._look.change(frames=True)
        wait_until(
            lambda: renderer._drawn is not None and renderer._drawn.look.frames, "the frames"
        )
        visitor.own.change(jog=None)
        wait_until(lambda: renderer._shown[number].look.frames, "the frames in its controls")

    async def sit_there() -> None:
        async with raw_browser(int(page.url.rpartition(":")[2])):
            await asyncio.to_thread(look_and_jog)

    asyncio.run(sit_there())


@pytest.mark.extensive
def test_controls_made_anew_take_their_gizmos_and_the_stage_along(page, bench):
    renderer = page._renderer

    def look_and_change() -> None:
        wait_until(lambda: renderer._panels, "the controls")
        ((number, visitor),) = renderer._visitors.items()
        scene, panels = visitor.client.scene, renderer._panels[number]
        next(p for p in panels if isinstance(p, CellPanel))._inputs._turn()
        next(p for p in panels if isinstance(p, GraspsPanel))._turn()
        assert scene.get_handle_by_name("/cell_gizmo") is not None
        assert scene.get_handle_by_name("/stage") is not None
        cell = bench.state.cell
        policy = replace(cell.policy, threshold=cell.policy.threshold + 0.01)
        bench.do(ChangeCell(replace(cell, policy=policy), "another threshold"), "Ada")
        wait_until(lambda: renderer._panels.get(number, panels) is not panels, "other controls")
        assert scene.get_handle_by_name("/cell_gizmo") is None
        assert scene.get_handle_by_name("/stage") is None

    async def sit_there() -> None:
        async with raw_browser(int(page.url.rpartition(":")[2])):
            await asyncio.to_thread(look_and_change)

    asyncio.run(sit_there())
    wait_until(lambda: not renderer._visitors, "the end of the browser")


def test_a_pose_of_a_calibration_that_is_gone_is_no_longer_chosen(page):
    renderer = page._renderer

    def choose_and_lose() -> None:
        wait_until(lambda: renderer._panels, "the controls")
        ((_, visitor),) = renderer._visitors.items()
        visitor.own.change(observation=0)
        wait_until(lambda: visitor.own.now.observation is None, "the end of the choice")

    async def sit_there() -> None:
        async with raw_browser(int(page.url.rpartition(":")[2])):
            await asyncio.to_thread(choose_and_lose)

    asyncio.run(sit_there())


def test_a_page_that_cannot_begin_leaves_its_port_free(bench, monkeypatch):
    ports = []

    def broken(server, *_, **__):
        ports.append(server.get_port())
        raise ValueError("no picture")

    monkeypatch.setattr(workbench.gui.page.server, "Renderer", broken)
    with pytest.raises(ValueError, match="no picture"):
        serve(bench, port=0)
    server = open_viser("127.0.0.1", ports[0])
    server.stop()


def test_other_axes_need_other_controls_and_another_tool_does_not(cell):
    arm = cell.arms[0]

    def with_arm(**fields):
        return replace(cell, arms=(replace(arm, **fields), *cell.arms[1:]))

    spare = replace(arm.tool, name="spare")
    assert not _needs_other_controls(cell, with_arm(tools=(arm.tool, spare), tool=spare))
    assert _needs_other_controls(cell, with_arm(axis_order=arm.axis_order[::-1]))
    assert _needs_other_controls(cell, with_arm(axis_signs=tuple(-s for s in arm.axis_signs)))


def test_what_somebody_drags_is_let_go_when_control_is_taken_from_them(page, bench):
    renderer = page._renderer

    def drag_and_lose_control() -> None:
        wait_until(lambda: renderer._panels, "the controls")
        ((number, visitor),) = renderer._visitors.items()
        held = DraggedThing(visitor.person.name, number, bench.state.cell.bin.T_world_bin)
        visitor.look.change(held=held)
        assert renderer._look.now.held is held
        bench.do(TakeControl(), "Ada")
        wait_until(lambda: renderer._look.now.held is None, "the end of the drag")

    async def sit_there() -> None:
        async with raw_browser(int(page.url.rpartition(":")[2])):
            await asyncio.to_thread(drag_and_lose_control)

    asyncio.run(sit_there())


@pytest.mark.extensive
def test_a_dark_page_keeps_its_floor_when_the_cell_changes(page, bench):
    renderer = page._renderer

    def darken_and_change() -> None:
        wait_until(lambda: renderer._panels, "the controls")
        ((number, visitor),) = renderer._visitors.items()
        panels = renderer._panels[number]
        panels[0]._turn()
        floor = visitor.client.scene.get_handle_by_name("/floor")
        cell, aside = bench.state.cell, pose_from_rpy((0.1, 0.0, 0.0))
        T = aside * cell.bin.T_world_bin
        moved = replace(cell, bin=replace(cell.bin, T_world_bin=T))
        bench.do(ChangeCell(moved, "the bin is moved"), "Ada")

        def is_laid_anew() -> bool:
            now = visitor.client.scene.get_handle_by_name("/floor")
            return now is not None and now is not floor

        wait_until(is_laid_anew, "the floor of this browser")
        floor = visitor.client.scene.get_handle_by_name("/floor")
        assert floor.cell_color == rgb_of(NIGHT_GRID[0])
        policy = replace(moved.policy, threshold=moved.policy.threshold + 0.01)
        bench.do(ChangeCell(replace(moved, policy=policy), "another threshold"), "Ada")
        wait_until(is_laid_anew, "the floor with other controls")
        assert renderer._visitors[number].is_dark

    async def sit_there() -> None:
        async with raw_browser(int(page.url.rpartition(":")[2])):
            await asyncio.to_thread(darken_and_change)

    asyncio.run(sit_there())


@pytest.mark.parametrize("goes_back", [False, True])
@pytest.mark.parametrize("name", ["_use", "_add_parts", "_draw_paths", "_pose"])
def test_of_a_scene_that_failed_everything_is_drawn_next_time(page, bench, states, name, goes_back):
    renderer, scene = page._renderer, page._renderer._scene
    wait_until(lambda: renderer._drawn is not None, "the first drawing")
    whole, failures, confirmed = getattr(scene, name), [], []
    renderer._player.drawn = confirmed.append

    def fail(*args):
        setattr(scene, name, whole)
        failures.append(1)
        confirmed.clear()
        if goes_back:
            renderer._bench = bench
        raise ValueError("no picture")

    setattr(scene, name, fail)
    cell = bench.state.cell
    T = pose_from_rpy((0.01, 0.0, 0.0)) * cell.bin.T_world_bin
    moved = replace(cell, bin=replace(cell.bin, T_world_bin=T))
    renderer._bench = SimpleNamespace(state=replace(states.planned, cell=moved), live=bench.live)
    renderer._look.change(time=0.2)
    wait_until(lambda: failures and confirmed, "a whole drawing")
    shown, node = moved if not goes_back else cell, scene._scene.get_handle_by_name
    for drawn in ("/parts/part-1", "/path/right", "/scan"):
        assert (node(drawn) is None) == goes_back, drawn
    at = node("/bin").position
    np.testing.assert_allclose(at, shown.bin.T_world_bin.translation, atol=1e-9)


def test_controls_that_failed_are_drawn_anew_and_what_plays_there_was_not_watched(page):
    renderer = page._renderer
    shown, confirmed = [], []

    def fail_once() -> None:
        wait_until(lambda: renderer._panels, "the controls")
        ((number, (header, *_)),) = renderer._panels.items()
        whole = header.show

        def show(old, new):
            if new.look.frames:
                shown.append(old)
                if len(shown) == 1:
                    raise ValueError("no controls")
            whole(old, new)

        header.show = show
        renderer._player.drawn = confirmed.append
        renderer._look.change(frames=True, browser=number)
        wait_until(lambda: len(shown) > 2, "the drawings after it")
        assert shown[0] is not None and shown[1] is None and shown[2] is not None
        framed = [view for view in confirmed if view.look.frames]
        assert 1 <= len(framed) < len(shown)

    async def sit_there() -> None:
        async with raw_browser(int(page.url.rpartition(":")[2])):
            await asyncio.to_thread(fail_once)

    asyncio.run(sit_there())
