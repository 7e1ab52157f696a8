"""How soon verdicts follow a drag: `pytest -n0 -s tests/browser/drag_figures.py`, by hand.

Eight parts, 100 grasps, two arms; the bin is dragged for three seconds, then the hand of a grasp.
"""

import os
import time
from dataclasses import replace

import numpy as np
import pytest
from hands import Camera, first_look, settle
from waiting import wait_until

from workbench.app.core.cycle.parts import UseDetections
from workbench.app.core.cycle.scanning import UseScan
from workbench.app.runtime.bench import Bench
from workbench.app.runtime.effect_runner import EffectRunner
from workbench.app.runtime.work import JOBS
from workbench.formats.cells.reading import read_cell
from workbench.gui.cell.panel import GIZMO
from workbench.gui.dragging.verdicts import LiveVerdicts
from workbench.gui.grasps.pose import GIZMO as HAND_GIZMO
from workbench.gui.scene.drag_overlay import DrawnVerdicts
from workbench.gui.scene.stage import T_WORLD_STAGE, size_of, view_of
from workbench.gui.shared.movable_frames import moving, pose_of
from workbench.journal.journal import Journal
from workbench.model.geometry import pose_from_rpy
from workbench.model.part_edits import grasp_of, with_grasp, with_part
from workbench.perception.simulation.piles import drop_parts
from workbench.perception.simulation.synthesize import synthesize
from workbench.plugins.progress import never, silent

SECONDS = 3.0

COUNT = """
() => {
  window.updates = 0;
  let last = "";
  new MutationObserver(() => {
    const said = [...document.querySelectorAll(".wb-told-kind")].map(one => one.innerText).join();
    if (said && said !== last) { window.updates++; last = said; }
  }).observe(document.body, {subtree: true, childList: true, characterData: true});
}
"""
"""Counts the verdicts that come to the page and differ from those before."""


@pytest.fixture
def bench(tmp_path):
    cell = read_cell("yumi")
    part = cell.parts[0]
    entry = replace(
        part.library.entries[0],
        angles=tuple(np.linspace(0.0, 2 * np.pi, 25, endpoint=False)),
        offsets=(-0.028, -0.02, -0.011, -0.002),
    )
    cell = with_part(cell, part.name, library=replace(part.library, entries=(entry,)))
    pile = drop_parts((part,) * 8, cell.bin, seed=3)
    bench = Bench(cell, Journal(tmp_path / "session"), effects=EffectRunner)
    bench.do(UseScan(synthesize(cell, pile, seed=3)), "Ada")
    bench.do(UseDetections(pile), "Ada")
    yield bench
    bench.close()


@pytest.fixture
def figures(monkeypatch):
    """Of each question when it was asked, and when its answer was drawn."""
    asked, drawn, shown = {}, [], {}
    ask, answered, draw = LiveVerdicts.ask, LiveVerdicts._take_answer, DrawnVerdicts.draw

    def noted_ask(self, *what):
        asked[self, self._asked + 1] = time.monotonic()
        ask(self, *what)

    def noted_answer(self, drag, number, state, result, T):
        shown[id(result)] = asked.get((self, number), 0.0)
        answered(self, drag, number, state, result, T)

    def noted_draw(self, dragged):
        draw(self, dragged)
        if dragged is not None and shown[id(dragged.glance)]:
            drawn.append(time.monotonic() - shown[id(dragged.glance)])

    monkeypatch.setattr(LiveVerdicts, "ask", noted_ask)
    monkeypatch.setattr(LiveVerdicts, "_take_answer", noted_answer)
    monkeypatch.setattr(DrawnVerdicts, "draw", noted_draw)
    return asked, drawn, shown


def dragged(screen, figures, what, camera, tip, way):
    """Drag to and fro for so long, and tell what came of it."""
    asked, drawn, answered = figures
    page = screen.page
    # The first answer, before anybody drags, waits for the worker to load what was compiled.
    wait_until(lambda: len(answered) > 0)
    page.mouse.move(*camera.pixel(tip))
    settle(page, 300)
    page.mouse.down()
    settle(page, 100)
    page.evaluate("() => { window.updates = 0; }")
    asked.clear()
    drawn.clear()
    began, used, steps = time.monotonic(), time.process_time(), 0
    while time.monotonic() < began + SECONDS:
        steps += 1
        page.mouse.move(*camera.pixel(tip + way * (0.5 - 0.5 * np.cos(0.2 * steps))))
        page.wait_for_timeout(20)
    took, used = time.monotonic() - began, time.process_time() - used
    assert drawn, f"the gizmo was missed: {steps} moves, {len(asked)} questions"
    ages = np.array(drawn) * 1000
    arrived = page.evaluate("() => window.updates")
    page.mouse.up()
    load = ", ".join(f"{one:.1f}" for one in os.getloadavg())
    print(
        f"\n{what}: {took:.1f} s, moves {steps}, asked {len(asked)}, drawn {len(ages)}, "
        f"others on the page {arrived}, age [ms] median {np.median(ages):.0f}, "
        f"95 % {np.percentile(ages, 95):.0f}, most {ages.max():.0f}; page's process "
        f"{used / took:.0%} of a processor; load {load}"
    )


def test_what_one_answer_takes_of_a_processor(bench):
    state, turn = bench.state, iter(range(1000))
    cell, part = state.cell, state.cell.parts[0]
    entry = part.library.entries[0]
    about = {"detections": state.detections, "avoided": (), "obstacles": (), "around": None}

    def of(thing):
        return moving(cell, thing, pose_of(cell, thing) * pose_from_rpy((1e-5 * next(turn), 0, 0)))

    def of_hand():
        T = grasp_of(entry).T_part_tcp * pose_from_rpy((1e-5 * next(turn), 0.0, 0.0))
        entries = (with_grasp(entry, replace(grasp_of(entry), T_part_tcp=T)),)
        return {"libraries": {part.name: replace(part.library, entries=entries)}}

    things = ("bin", cell.fixtures[0].name, "robot", "right place 1")
    for what, change in [(one, lambda one=one: of(one)) for one in things] + [("hand", of_hand)]:
        JOBS["glance"](cell, about | {"change": change()}, silent, never)
        began = time.process_time()
        for _ in range(10):
            found = JOBS["glance"](cell, about | {"change": change()}, silent, never)
        took = (time.process_time() - began) / 10
        print(f"\n{what}: {len(found.reasons)} candidates, {took * 1000:.0f} ms of a processor")


def test_how_soon_verdicts_follow(screen, bench, figures):
    cell = bench.state.cell
    screen.page.evaluate(COUNT)
    screen.tab("Cell")
    screen.press("Show gizmo")
    settle(screen.page, 1500)
    tip = cell.bin.T_world_bin.translation + [0, 0, 0.9 * GIZMO]
    way = np.array([0.0, 0.0, -0.03])
    parts = bench.state.detections
    dragged(screen, figures, "the bin", first_look(screen.page, cell), tip, way)
    settle(screen.page, 2000)
    figures[2].clear()
    bench.do(UseDetections(parts), "Ada")
    part = bench.state.cell.parts[0]
    screen.tab("Grasps")
    screen.press("Edit grasps")
    settle(screen.page, 1500)
    T = grasp_of(part.library.entries[0]).T_part_tcp
    x = np.array(T.rotation[:, 0])
    handle = T_WORLD_STAGE.act(T.translation + 0.9 * HAND_GIZMO * size_of(part) * x)
    camera = Camera(screen.page, *view_of(part))
    dragged(screen, figures, "the hand", camera, handle, 0.005 * x)
    settle(screen.page, 2000)
