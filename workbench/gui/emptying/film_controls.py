"""The controls of the film of an emptied pile, in one browser only: nothing real moves by it."""

from dataclasses import replace

import viser

from workbench.app.core.state import Phase, State
from workbench.app.emptying.film import Film
from workbench.app.runtime.live import Live
from workbench.gui.emptying.reel import end_of, reel_of
from workbench.gui.help.groups import group
from workbench.gui.shared.look import View
from workbench.gui.shared.own import Showing
from workbench.gui.shared.views import line
from workbench.gui.shared.visitor import Visitor
from workbench.gui.texts.labels import LabelText

SLIDER_STEP = 0.05
"""[s] Of the slider."""

SPEEDS = {"1 x": 1.0, "2 x": 2.0, "4 x": 4.0, "8 x": 8.0}

PLAYS = "Shows in your view alone how the chosen pile is emptied: the robot as planned, all parts."


class FilmControls:
    """Play, a slider, the speed, what stays, and the end of the film.

    Concurrency: clicks and drags only change the own look; the renderer's thread draws.
    """

    def __init__(self, visitor: Visitor):
        """Add the controls."""
        self._visitor = visitor
        self._mine: float | None = None
        self._is_written = False
        self._pile = 0
        gui = visitor.gui
        with group(gui, "Film of the chosen pile") as self._group:
            gui.add_html('<div class="wb-buttons wb-three"></div>')
            self._says = gui.add_html("")
            self._time = gui.add_slider(
                "Film [s]",
                min=0.0,
                max=1.0,
                step=SLIDER_STEP,
                initial_value=0.0,
                hint="Drag through the film; it is simulated, and nothing is sent.",
            )
            self._play = gui.add_button("Play film", icon=viser.Icon.PLAYER_PLAY, hint=PLAYS)
            self._stays = gui.add_button(
                "What stays",
                icon=viser.Icon.EYE,
                color="gray",
                hint="The end of the film: each part that stays is coloured by why.",
            )
            self._end = gui.add_button(
                "End film", icon=viser.Icon.X, color="gray", hint="See the cell as it is again."
            )
            self._speed = gui.add_dropdown("Speed", tuple(SPEEDS), initial_value="2 x")
            self._left = gui.add_html("")
        self._play.on_click(lambda _: self._play_or_pause())
        self._stays.on_click(lambda _: self._go_to_end())
        self._end.on_click(lambda _: visitor.own.change(film=None))
        visitor.by_hand(self._time, lambda time: self._go_to(float(time)))
        visitor.by_hand(self._speed, lambda _: visitor.own.show(self._as_fast))

    def show(self, old: View | None, new: View, pile: int) -> None:
        """Bring what is shown from `old` to `new`, for the pile of that index."""
        self._pile = pile
        if self._group.visible != (is_there := new.state.emptying is not None):
            self._group.visible = is_there
        showing = new.own.film
        if old is None or old.state is not new.state or old.live.films is not new.live.films:
            problem = self._problem(new.state, new.live)
            for button in (self._play, self._stays):
                self._visitor.allow(button, problem)
        self._visitor.allow(self._end, "" if showing is not None else "no film is shown")
        if old is not None and old.own.film is showing and old.filmed is new.filmed:
            return
        is_playing = showing is not None and showing.is_playing
        label = "Pause" if is_playing else "Play film"
        if self._play.label != label:
            self._play.label = label
            self._play.icon = viser.Icon.PLAYER_PAUSE if is_playing else viser.Icon.PLAYER_PLAY
        self._time.disabled = showing is None
        self._says.content = line(
            "Play shows in the scene how the pile was emptied, in your view alone."
            if new.filmed is None
            else self._visitor.words.render(LabelText.SENTENCE(text=new.filmed.says)),
            kind="hint" if new.filmed is None else "result",
        )
        if showing is None:
            self._mine = None
            self._time.value = 0.0
            return
        most = max(round(showing.seconds, 2), SLIDER_STEP)
        if self._time.max != most:
            self._time.max = most
        # The browser that drags knows best where its own slider stands.
        if showing.time != self._mine:
            self._is_written = True
            self._time.value = min(round(showing.time, 2), most)
        elif self._is_written:
            # The slider was moved from here, too: whose word came last to the browser is not known,
            # and a value that is said once more is not sent.
            self._is_written = False
            self._time.value = most if showing.time == 0.0 else 0.0
            self._time.value = min(round(showing.time, 2), most)

    def show_left(self, html: str) -> None:
        """Say what stays of the chosen pile."""
        self._left.content = html

    def change_to(self, pile: int) -> None:
        """Another pile is chosen: a film that is shown goes on with that one, from its start."""
        self._pile = pile
        before = self._visitor.own.now.film
        film = None if before is None else self._film()
        if before is not None and film is not None and film is not before.film:
            self._show(film, 0.0, is_playing=before.is_playing)
        self._visitor.own.change()

    def show_part(self, pile: int, name: str) -> None:
        """Show a part that stays, by its name, at the end of the film of its pile."""
        self._pile = pile
        film = self._film()
        if film is None:
            return
        self._show(film, end_of(reel_of(film)), is_playing=False)
        number = next((k for k, _ in film.left if f"part-{k + 1}" == name), None)
        self._visitor.own.show(lambda showing: replace(showing, chosen=number))

    def _film(self) -> Film | None:
        """The film of the chosen pile; None where it cannot be shown, which is reported then."""
        bench = self._visitor.bench
        problem = self._problem(bench.state, bench.live)
        films = bench.live.films
        if problem or films is None or self._pile >= len(films.films):
            self._visitor.notify("No film", problem or "there is no film of this pile")
            return None
        return films.films[self._pile]

    def _problem(self, state: State, live: Live) -> str:
        """Why no film can be shown now; empty when one can."""
        found = state.emptying
        if found is None:
            return "empty piles first"
        if live.films is None or live.films.emptying is not found:
            return "the film is not kept on record; the same seed empties the same piles again"
        if found.cell_digest != state.cell.digest:
            return "the cell has changed since; empty the piles again"
        if state.phase is Phase.SENDING:
            return "while a plan is sent, everybody sees where the robot is"
        return ""

    def _play_or_pause(self) -> None:
        film = self._film()
        if film is None:
            return
        now = self._visitor.own.now.film
        if now is None or now.film is not film:
            self._show(film, 0.0, is_playing=True)
            return
        is_over = now.time >= now.seconds
        self._visitor.own.show(
            lambda showing: replace(
                showing,
                is_playing=not showing.is_playing,
                time=0.0 if is_over else showing.time,
                chosen=None,
            )
        )

    def _go_to_end(self) -> None:
        film = self._film()
        if film is not None:
            self._show(film, end_of(reel_of(film)), is_playing=False)

    def _show(self, film: Film, time: float, *, is_playing: bool) -> None:
        visitor = self._visitor
        found = visitor.bench.state.emptying
        if found is None:
            return
        visitor.turn_away()
        pile = found.plain[self._pile]
        kinds = {
            int(left_part.part.removeprefix("part-")) - 1: left_part.kind for left_part in pile.left
        }
        seconds = reel_of(film).seconds
        speed = SPEEDS.get(str(self._speed.value), 1.0)
        showing = Showing(film, seconds, kinds, time, is_playing, speed)
        visitor.own.change(jog=None, observation=None, film=showing)

    def _go_to(self, time: float) -> None:
        self._mine = time
        self._visitor.own.show(
            lambda showing: replace(
                showing, time=max(0.0, min(time, showing.seconds)), is_playing=False
            )
        )

    def _as_fast(self, showing: Showing) -> Showing:
        return replace(showing, speed=SPEEDS.get(str(self._speed.value), 1.0))
