"""The one thread that draws: the newest view, at most thirty times a second."""

import logging
import queue
import threading
import time
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path

import viser

from workbench.app.core.cycle.scanning import TakeScan
from workbench.app.core.state import Phase, State
from workbench.app.picking.facts import bin_check_of
from workbench.app.review.history import History
from workbench.app.runtime.bench import Bench
from workbench.gui.dragging.verdicts import is_same_scene
from workbench.gui.drawing.film_scene import FilmScene
from workbench.gui.drawing.fixes import FixFinder
from workbench.gui.drawing.following import keep_up
from workbench.gui.drawing.own_scene import OwnScene
from workbench.gui.drawing.own_views import OwnViews, has_lost_observation, is_news
from workbench.gui.drawing.player import Player
from workbench.gui.drawing.poses import PoseFinder
from workbench.gui.drawing.reach import Reaches
from workbench.gui.drawing.sureness import Sureness
from workbench.gui.emptying.reel import advance
from workbench.gui.page.header import Header
from workbench.gui.page.presence import BrowserCount
from workbench.gui.page.tabs import tabs_of
from workbench.gui.page.theme import Theme
from workbench.gui.scene.picture import ScenePicture
from workbench.gui.shared.calibrating import solve
from workbench.gui.shared.look import CalibrationAnswer, Look, Pose, SharedLook, View
from workbench.gui.shared.playback import Run, timeline
from workbench.gui.shared.viser_server import (
    language_of,
    panel_width_of,
    person_of,
    wants_dark,
)
from workbench.gui.shared.visitor import Panel, Visitor
from workbench.gui.statistics.counting import EntryCounter
from workbench.gui.texts.page import PageText
from workbench.gui.words.translation import speak
from workbench.model.cell import Cell
from workbench.model.digest import digest_of
from workbench.model.prediction import Predictions
from workbench.words.words import words_of

log = logging.getLogger(__name__)

FRAME = 1 / 30
"""Shortest time between two drawings [s]."""

BUSY = 0.1
"""Longest time between two drawings while something goes on that nobody reports [s]."""

QUIET = 0.5
"""Longest time between two drawings otherwise [s]."""


class Renderer:
    """Draws the scene and the controls of every browser.

    Whoever changes something sets `_woken`; this thread looks what is newest and draws what
    differs from what it has drawn.  Browsers come and go through a queue, so that widgets are
    made and changed by this thread alone.

    Lifetime: from construction until `close`.
    """

    def __init__(
        self,
        server: viser.ViserServer,
        bench: Bench | History,
        theme: Theme,
        *,
        style: str,
        most_points: int,
        predictions: Predictions | None,
        folders: Mapping[str, Path],
    ):
        """Draw the cell and start.

        Args:
            server: to draw on.
            bench: whose state is drawn, or a recorded session.
            theme: of the page.
            style: style sheet of the page.
            most_points: of a scan.
            predictions: what a study says about the threshold.
            folders: where the parts lie, by name.
        """
        self._server = server
        self._bench = bench
        self._theme = theme
        self._style = style
        self._predictions = predictions
        self._folders = folders
        self._woken = threading.Event()
        self._closed = threading.Event()
        self._look = SharedLook(self._woken.set)
        self._arrivals: queue.SimpleQueue[tuple[viser.ClientHandle, bool]] = queue.SimpleQueue()
        self._visitors: dict[int, Visitor] = {}
        self._panels: dict[int, tuple[Panel, ...]] = {}
        self._runs: tuple[Run, ...] = ()
        self._player = Player(bench, self._look)
        self._shown: dict[int, View] = {}
        self._presence = (
            None if isinstance(bench, History) else BrowserCount(bench, time.monotonic())
        )
        self._finder = PoseFinder()
        self._own_views = OwnViews()
        self._reaches = Reaches(self._woken.set)
        self._fixes = FixFinder(self._woken.set)
        self._sureness = Sureness(self._woken.set)
        self._counted = EntryCounter(bench, self._woken.set)
        self._drawn: View | None = None
        # What the scene shows, None where drawing it failed; and panels that failed.
        self._in_scene: View | None = None
        self._stale: set[Panel] = set()
        with server.atomic():
            self._scene = ScenePicture(server, bench.cell, most_points=most_points)
        self._unsubscribe = bench.subscribe(lambda old, new: self._woken.set())
        server.on_client_connect(self._on_arrival)
        server.on_client_disconnect(self._on_leave)
        self._thread = threading.Thread(target=self._run, name="renderer", daemon=True)
        self._thread.start()

    def close(self) -> bool:
        """End the thread; whether it was not ended before."""
        if self._closed.is_set():
            return False
        self._closed.set()
        self._woken.set()
        self._unsubscribe()
        self._thread.join()
        self._player.close()
        self._fixes.close()
        self._sureness.close()
        self._reaches.close()
        self._counted.close()
        return True

    async def _on_arrival(self, client: viser.ClientHandle) -> None:
        self._arrivals.put((client, True))
        self._woken.set()

    async def _on_leave(self, client: viser.ClientHandle) -> None:
        self._arrivals.put((client, False))
        self._woken.set()

    def _run(self) -> None:
        last = time.monotonic()
        while not self._closed.is_set():
            self._woken.wait(self._patience())
            self._woken.clear()
            elapsed = time.monotonic() - last
            self._closed.wait(max(0.0, FRAME - elapsed))
            now = time.monotonic()
            _run_shielded(partial(self._player.step, self._drawn, self._visitors, now - last))
            _run_shielded(partial(self._run_films, now - last))
            _run_shielded(self._draw)
            last = now

    def _run_films(self, elapsed: float) -> None:
        """Move the films of browsers on; the first drawing after Play was pressed only begins."""
        for number, view in self._shown.items():
            if view.own.film is not None and view.own.film.is_playing:
                self._visitors[number].own.show(partial(advance, elapsed=elapsed))

    def _patience(self) -> float:
        if self._look.now.is_playing or any(map(_plays_film, self._visitors.values())):
            return FRAME
        view = self._drawn
        if view is not None and view.state.phase is Phase.SENDING:
            return FRAME
        is_busy = view is not None and (
            view.state.job is not None or view.live.joints or view.live.getting_ready is not None
        )
        return BUSY if is_busy else QUIET

    def _draw(self) -> None:
        # Before anything is taken from the queue: a view may fail, and is tried again.
        old, new = self._drawn, self._view()
        waiting = self._waiting()
        self._count_people(waiting)
        for client, is_here in waiting:
            if is_here:
                _run_shielded(partial(speak, client, words_of(language_of(client))))
                _run_shielded(partial(self._welcome, client, new, is_dark=wants_dark(client)))
            else:
                self._bid_farewell(client)
        if old is not None and _needs_other_controls(old.state.cell, new.state.cell):
            for visitor in tuple(self._visitors.values()):
                _run_shielded(partial(self._rebuild, visitor, new))
        with self._server.atomic():
            is_drawn = _run_shielded(partial(self._scene.draw, self._in_scene, new))
        self._in_scene = new if is_drawn else None
        self._end_own_views(old, new)
        for visitor in tuple(self._visitors.values()):
            _run_shielded(partial(self._show, visitor, new))
        self._drawn = new
        playing = (some for number, some in self._panels.items() if number == new.look.browser)
        if is_drawn and all(map(self._stale.isdisjoint, playing)):
            self._player.drawn(new)

    def _end_own_views(self, old: View | None, new: View) -> None:
        """The robot is where everybody sees it, when a plan is played or sent, and after that."""
        is_begun = new.look.is_playing and (old is None or not old.look.is_playing)
        is_sending = new.state.phase is Phase.SENDING
        is_other = old is not None and old.state.cell is not new.state.cell
        for visitor in self._visitors.values():
            follows = bool(visitor.lacks(new.state, TakeScan))
            held = self._look.now.held
            if follows and held is not None and held.browser == visitor.number:
                # Who has lost control in the middle of a drag cannot let go of it.
                self._look.change(held=None)
            if is_begun or is_sending or is_other:
                visitor.own.end()
            elif follows:
                visitor.own.let_go()
            elif has_lost_observation(visitor.own.now, old and old.state, new.state):
                visitor.own.change(observation=None)
            for name in ("dragged", "carried"):
                shown = getattr(visitor.own.now, name)
                if shown is not None and (
                    is_begun or follows or not is_same_scene(shown.state, new.state)
                ):
                    visitor.own.change(**{name: None})
            if visitor.own.now.film is not None and old is not None and is_news(old, new):
                visitor.own.change(film=None)

    def _show(self, visitor: Visitor, shared: View) -> None:
        """Bring one browser's controls, and what it alone sees, to the newest view."""
        old, panels = self._shown.get(visitor.number), self._panels.get(visitor.number, ())
        failed = self._stale.intersection(panels)
        self._stale.update(panels)  # until they are drawn: this may fail, and is tried again
        new = self._own_views.of(visitor.own.now, old, shared)
        for panel in panels:
            if _run_shielded(partial(panel.show, None if panel in failed else old, new)):
                self._stale.discard(panel)
        _run_shielded(visitor.show_button_texts)
        self._shown[visitor.number] = new

    def _count_people(self, waiting: list[tuple[viser.ClientHandle, bool]]) -> None:
        """Browsers come and go: with them control, what they drag, and what they compare."""
        now = time.monotonic()
        for client, is_here in waiting:
            held = self._look.now.held
            if not is_here and held is not None and held.browser == client.client_id:
                self._look.change(held=None)
            if not is_here and self._look.now.searcher == client.client_id:
                self._look.change(search=None, searcher=None)
            if self._presence is not None:
                _run_shielded(partial(_count, self._presence, client, now, is_here=is_here))
        if self._presence is not None:
            _run_shielded(partial(self._presence.look, now))

    def _view(self) -> View:
        state = self._bench.state
        before = self._drawn.state if self._drawn is not None else None
        if before is None or before.plans != state.plans:
            self._runs = timeline(*state.plans)
        live = self._bench.live
        keep_up(self._look, before, state, live, self._runs)
        look, end = self._look.now, max((run.end for run in self._runs), default=0.0)
        return View(
            state,
            live,
            look,
            self._runs,
            time.time(),
            self._poses(state, look),
            self._fixes.of(state, look.candidate),
            self._fixes.without_plan(state),
            self._reaches.of(state.cell, look.reach),
            self._counted.of(state),
            self._calibration(state),
            bin_check_of(state),
            isinstance(self._bench, History),
            self._player.unseen(state.plans, end),
            self._player.hidden(state.plans, end),
            self._sureness.of(state, look.candidate),
        )

    def _calibration(self, state: State) -> CalibrationAnswer:
        """The calibration from the scanned poses, computed again when they have changed."""
        before = self._drawn
        if (
            before is not None
            and before.state.observations is state.observations
            and before.state.cell is state.cell
        ):
            return before.calibration
        return solve(state)

    def _poses(self, state: State, look: Look) -> tuple[Pose, ...]:
        """The poses of the chosen candidate, worked out when another one is chosen."""
        candidates = state.candidates or ()
        if look.candidate is None or look.candidate >= len(candidates):
            return ()
        before = self._drawn
        is_same = (
            before is not None
            and before.state.candidates is state.candidates
            and before.look.candidate == look.candidate
        )
        if before is not None and is_same:
            return before.poses
        return self._finder.poses(state, candidates[look.candidate])

    def _waiting(self) -> list[tuple[viser.ClientHandle, bool]]:
        found: list[tuple[viser.ClientHandle, bool]] = []
        while not self._arrivals.empty():
            found.append(self._arrivals.get())
        return found

    def _welcome(self, client: viser.ClientHandle, view: View, *, is_dark: bool) -> None:
        visitor = Visitor(client, self._bench, self._look, self._predictions, self._folders)
        visitor.is_dark = is_dark
        self._visitors[client.client_id] = visitor
        # All at once: what is pressed before somebody listens would be lost.
        with client.atomic():
            title = PageText.CELL(name=view.state.cell.name)
            client.gui.set_panel_label(visitor.words.render(title))
            if width := panel_width_of(client):
                client.gui.main_panel.set_width(width)
            header = Header(visitor, self._theme, self._style)
            scenes = (OwnScene(visitor), FilmScene(visitor))
            panels = (header, *scenes, *tabs_of(visitor, self._woken.set, header.transport.slider))
            for panel in panels:
                panel.show(None, view)
            visitor.show_button_texts()
        self._shown[client.client_id] = view
        self._panels[client.client_id] = panels

    def _bid_farewell(self, client: viser.ClientHandle) -> None:
        self._forget_panels(client.client_id)
        self._shown.pop(client.client_id, None)
        visitor = self._visitors.pop(client.client_id, None)
        if visitor is not None:
            _run_shielded(partial(visitor.end, is_gone=True))

    def _forget_panels(self, number: int) -> None:
        self._stale.difference_update(self._panels.pop(number, ()))

    def _rebuild(self, visitor: Visitor, view: View) -> None:
        """Make the controls of a browser anew, for another cell."""
        self._forget_panels(visitor.number)
        _run_shielded(partial(visitor.end, is_gone=False))
        visitor.gui.reset()
        self._welcome(visitor.client, view, is_dark=visitor.is_dark)


def _plays_film(visitor: Visitor) -> bool:
    film = visitor.own.now.film
    return film is not None and film.is_playing


def _count(
    presence: BrowserCount, client: viser.ClientHandle, now: float, *, is_here: bool
) -> None:
    if is_here:
        presence.enter(client.client_id, person_of(client))
    else:
        presence.leave(client.client_id, now)


def _needs_other_controls(before: Cell, now: Cell) -> bool:
    """Whether controls were made for arms that are not there any more, or for other things."""

    def made_for(cell: Cell) -> str:
        arms = [
            (arm.name, arm.joints, cell.robot.limits(arm.joints), arm.axis_order)
            + (arm.axis_signs, arm.mapping)
            for arm in cell.arms
        ]
        return digest_of((arms, cell.policy))

    return before is not now and made_for(before) != made_for(now)


def _run_shielded(action: Callable[[], None]) -> bool:
    """Draw the scene or the controls of one browser; the others do not suffer if that fails.

    Returns:
        Whether it was drawn.

    A rim: a browser may have gone, and nothing that cannot be drawn may end the page.
    """
    try:
        action()
    except Exception:
        log.exception("something could not be drawn")
        return False
    return True
