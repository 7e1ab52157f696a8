"""One browser: whose it is, what it may ask, and how it hears that something is refused."""

import logging
from collections.abc import Callable, Iterable, Mapping, Set
from functools import cached_property, partial
from pathlib import Path
from typing import Any, Literal, Protocol

import viser
from viser._messages import HotkeyKey

from workbench.app.core.command import Command
from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.scanning import TakeScan
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.core.decide import NOT_REPORTED, check_allowed
from workbench.app.core.people import NOBODY, Person
from workbench.app.core.rights import lacks_right, obstacle
from workbench.app.core.state import Phase, State
from workbench.app.review.history import History
from workbench.app.runtime.bench import Bench
from workbench.gui.shared.look import CLOCK, PLAYBACK, SharedLook, SteeredLook, View
from workbench.gui.shared.own import OwnLook
from workbench.gui.shared.tables import make_text_css, named_css, primary_css
from workbench.gui.shared.views import sentence
from workbench.gui.shared.viser_server import (
    buttons_of,
    element_id,
    language_of,
    person_of,
    wants_less_motion,
)
from workbench.model.cell import Cell
from workbench.model.errors import CommandRefused, WorkbenchError
from workbench.model.messages.message import Message, plain
from workbench.model.prediction import Predictions
from workbench.words.words import Words, words_of

log = logging.getLogger(__name__)

SECONDS_TO_READ = 8.0

RECORDED = "this is a recorded session: it is read-only"

SOMEBODY = "somebody"
"""Stands for the name that the approval's dialog asks for where nobody has logged in."""

Control = viser.GuiButtonHandle | viser.GuiUploadButtonHandle


class Visitor:
    """One browser that is connected.

    Lifetime: from connect to disconnect; a reconnect makes a new one.

    Concurrency: any thread.
    """

    def __init__(
        self,
        client: viser.ClientHandle,
        bench: Bench | History,
        look: SharedLook,
        predictions: Predictions | None = None,
        folders: Mapping[str, Path] | None = None,
    ):
        """A browser without controls yet."""
        self.client = client
        self.person: Person = person_of(client)
        self.gui = client.gui
        self.bench = bench
        self.look = SteeredLook(look, self._may_steer)
        self.own = OwnLook(look.change)
        self.predictions = predictions
        self.folders: Mapping[str, Path] = folders or {}
        self.is_dark = False
        self._hints: dict[int, str | None] = {}
        self._told: dict[str, str] = {}
        self._named: dict[str, tuple[str, str, str]] = {}
        self._primary: dict[str, str] = {}
        self._style: viser.GuiHtmlHandle | None = None
        self._endings: list[tuple[Callable[[], None], bool]] = []
        self._forms: list[Callable[[], str]] = []

    @cached_property
    def words(self) -> Words:
        """The words of this browser's language."""
        return words_of(language_of(self.client))

    @cached_property
    def wants_less_motion(self) -> bool:
        """Whether the system of this browser asks for little motion."""
        return wants_less_motion(self.client)

    @property
    def is_recorded(self) -> bool:
        """Whether this is a recorded session: all of it can be viewed, nothing be done."""
        return isinstance(self.bench, History)

    @property
    def is_known(self) -> bool:
        """Whether who sits there has said who it is; without a login nobody has."""
        return self.person.name != NOBODY

    @property
    def cell(self) -> Cell:
        """The cell as it is now."""
        return self.bench.state.cell

    @property
    def number(self) -> int:
        """Identifies this browser."""
        return self.client.client_id

    def turn_away(self) -> None:
        """What this browser shows from now on is no plan: what it plays stops for all."""
        if self.look.now.is_playing and self.look.now.browser == self.number:
            self.look.change(is_playing=False, by=None)

    def on_press(self, button: viser.GuiButtonHandle, command: Callable[[], Command]) -> None:
        """Have a button give the command that is made when it is pressed."""

        @button.on_click
        def _(_: Any) -> None:
            self.ask(command)

    def by_hand(self, control: Any, used: Callable[[Any], object]) -> None:
        """Have a control's new value used when it is a person's, not the renderer's.

        Only a person's hand comes with a browser; who moves it is heard in the order of moving.
        """

        @control.on_update
        async def _(event: Any) -> None:
            if event.client is not None:
                used(event.target.value)

    def unseen(self, pressed: Callable[[], object]) -> str:
        """The id of a button for HTML to press; see `tables`.  `hide` takes it out of sight."""
        button = self.gui.add_button("·")

        @button.on_click
        def _(_: Any) -> None:
            pressed()

        return element_id(button)

    def rows(self, count: int, pressed: Callable[[int], object]) -> list[str]:
        """Create `count` hidden buttons and return their ids; `pressed` gets the button's index."""
        buttons = [self.unseen(partial(pressed, number)) for number in range(count)]
        self.hide(buttons)
        return buttons

    def hide(self, buttons: Iterable[str]) -> None:
        """Take unseen buttons, and the room they would have, out of sight."""
        self.gui.add_html(hidden_css(buttons))

    def on_key(self, key: HotkeyKey, says: str, pressed: Callable[[], object]) -> None:
        """Have a key do something while no field is typed in; listed by Ctrl+K.

        Nothing that lets a robot move has a key: that takes a hand on a button.  W, A, S, D, Q
        and E are viser's own: they move the camera.
        """

        @self.gui.add_command(says, hotkey=key).on_trigger
        def _(_: Any) -> None:
            pressed()

    def on_end(self, action: Callable[[], None], *, in_scene: bool = False) -> None:
        """Have something ended when the browser has gone, or its controls are made anew.

        Args:
            action: ends it.
            in_scene: it only changes what this browser shows, so who has gone does not need it.
        """
        self._endings.append((action, in_scene))

    def end(self, *, is_gone: bool) -> None:
        """These controls are used no more; `is_gone` says whether the browser is."""
        for action, in_scene in self._endings:
            if in_scene and is_gone:
                continue
            try:
                action()
            except Exception:
                # A rim: one thing that cannot be ended keeps no other one going.
                log.exception("what a browser had going could not be ended")

    def lacks(self, state: State, command: type) -> str:
        """Why a command of this type is not this person's now, in their language; else empty.

        A recorded session is everybody's to look at, whoever was in control then.
        """
        if self.is_recorded:
            return ""
        return self.words.render(lacks_right(state, command, self.person.name, self.person.role))

    def obstacle(self, state: State, command: type) -> str:
        """Why a command of this type from this browser is not in order now; empty when it is."""
        if self.is_recorded:
            return RECORDED
        return self.lacks(state, command) or self.words.render(obstacle(state, command))

    def refusal(
        self,
        state: State,
        command: Command,
        now: float,
        joints: Mapping[str, float] = NOT_REPORTED,
    ) -> Message | None:
        """Why the rules would refuse a command from this browser now; None when they would not."""
        if self.is_recorded:
            return plain(RECORDED)
        name = self.person.name
        if isinstance(command, Approve) and name == NOBODY:
            name = SOMEBODY
        try:
            check_allowed(state, command, name, now, joints, self.person.role)
        except CommandRefused as error:
            return error.message
        return None

    def add_form(self, not_applied: Callable[[], str]) -> None:
        """Have each Save ask what a person does first with the typed fields; empty: nothing."""
        self._forms.append(not_applied)

    def not_applied(self) -> str:
        """What this person does first with fields that are typed and not applied; else empty."""
        return next(filter(None, (stated() for stated in self._forms)), "")

    def save(self, command: Callable[[], Command]) -> bool:
        """Give a command that saves; refused while something is typed and not applied."""
        if typed := self.not_applied():
            self.notify("Refused", typed)
            return False
        return self.ask(command)

    def admit(self, control: Control, state: State, command: type, *, otherwise: str = "") -> None:
        """Let a control be used while its command is in order; it says why not.

        Args:
            control: that gives the command.
            state: as it is now.
            command: its type.
            otherwise: what is missing besides; empty when nothing is.
        """
        self.allow(control, self.obstacle(state, command) or otherwise)

    def allow(self, control: Control, problem: str) -> None:
        """Let a control be used, or have it say why not; empty: it can be."""
        control.disabled = bool(problem)
        self.explain(control, problem)

    def explain(self, control: Control, problem: str) -> None:
        """Have a control say why it cannot be used; empty: what it said when it was made."""
        hint = self._hints.setdefault(id(control), control.hint)
        wanted = sentence(problem) or hint
        if control.hint != wanted:
            control.hint = wanted
        self._told[element_id(control)] = wanted or ""

    def emphasise(self, button: viser.GuiButtonHandle | None, tab: str = "Cycle") -> None:
        """Have the button of a tab's next step filled, and no other one there; None: none is."""
        self._primary[tab] = "" if button is None else element_id(button)

    def name(self, three: viser.GuiVector3Handle, names: tuple[str, str, str]) -> None:
        """Have three numbers in a row say what each is; otherwise they are x, y and z."""
        self._named[element_id(three)] = names

    def show_button_texts(self) -> None:
        """Bring what buttons and numbers say to where the page shows it, after that has changed."""
        if self._style is None:
            # Those that nothing is ever explained of say what they were made with.
            for control in buttons_of(self.gui):
                self._told.setdefault(element_id(control), control.hint or "")
        # Texts within styles are nothing that a translation of HTML finds.
        say = self.words.say
        named = {key: (say(x), say(y), say(z)) for key, (x, y, z) in self._named.items()}
        rules = named_css(named) + make_text_css(
            {key: say(text) for key, text in self._told.items()}
        )
        rules += "".join(primary_css(button) for button in self._primary.values() if button)
        content = f'<style class="wb-style">{rules}</style>'
        if self._style is None:
            self._style = self.gui.add_html(content)
        elif self._style.content != content:
            self._style.content = content

    def _may_steer(self, fields: Set[str]) -> bool:
        """Whether this person may change what everybody looks at.

        Those who approve have to play the plan, in control or not; viewers follow.  While a plan is
        sent, its picture follows the robot.
        """
        if fields & CLOCK and self.bench.state.phase is Phase.SENDING:
            return False
        needed = WatchPlan if fields <= PLAYBACK else TakeScan
        return not self.lacks(self.bench.state, needed)

    def give(self, command: Command, name: str = "") -> None:
        """Give a command.

        Args:
            command: what is asked for.
            name: of a person who has said who it is for this once; empty: who sits there.

        Raises:
            CommandRefused: the rules do not allow it.
        """
        # Who is logged in speaks for nobody else.
        actor = self.person.name if self.is_known or not name else name
        self.bench.do(command, actor, self.person.role)

    def ask(self, command: Callable[[], Command], name: str = "") -> bool:
        """Make a command and give it; a refusal is reported in this browser only.

        Args:
            command: makes it.
            name: see `give`.

        Returns:
            Whether it was carried out.
        """
        return self.attempt(lambda: self.give(command(), name))

    def attempt(self, action: Callable[[], object]) -> bool:
        """Do something for this browser; a refusal is reported in it only.

        Returns:
            Whether it was done.
        """
        try:
            action()
        except WorkbenchError as error:
            self.notify("Refused", self.words.render(error.message))
        except Exception as error:
            # A rim: nothing that goes wrong for one browser may end the page for all.
            log.exception("what the page was asked for failed")
            self.notify("Internal error", f"{type(error).__name__}: {error}")
        else:
            return True
        return False

    def notify(self, title: str, text: str, *, color: Literal["red", "blue"] = "red") -> None:
        """Show a note in this browser; a red one when something did not happen."""
        self.client.add_notification(title, text, color=color, auto_close_seconds=SECONDS_TO_READ)


class Panel(Protocol):
    """The controls of one tab in one browser; holds handles and no values of the domain."""

    def show(self, old: View | None, new: View) -> None:
        """Bring what is shown from `old` (None: nothing yet) to `new`."""
        ...


def hidden_css(controls: Iterable[str]) -> str:
    """A style, as HTML, that takes controls with these ids out of sight."""
    rules = "".join(f'div:has(> [id="{control}"]){{display:none}}' for control in controls)
    return f'<style class="wb-style">{rules}</style>'


def whole(value: Any) -> Any:
    """A number as an integer if it is one; anything else as it came, for the rules to refuse."""
    return int(value) if isinstance(value, float) and value.is_integer() else value
