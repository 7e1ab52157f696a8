"""One browser: whose it is, what it may ask, and how it hears that something is refused."""

import logging
from collections.abc import Callable, Iterable, Mapping, Set
from pathlib import Path
from typing import Any, Literal, Protocol

import viser
from viser._messages import HotkeyKey

from workbench.app.core.commands import Command, TakeScan, WatchPlan
from workbench.app.core.people import Person
from workbench.app.core.rights import NOBODY, lacks_right, obstacle
from workbench.app.core.rules import NOT_REPORTED, allowed
from workbench.app.core.state import State
from workbench.app.review.history import History
from workbench.app.runtime.bench import Bench
from workbench.gui.shared.look import PLAYBACK, SharedLook, SteeredLook, View
from workbench.gui.shared.own import OwnLook
from workbench.gui.shared.viser_server import element_id, person_of
from workbench.model.cell import Cell
from workbench.model.errors import CommandRefused, WorkbenchError
from workbench.model.prediction import Predictions

log = logging.getLogger(__name__)

SECONDS_TO_READ = 8.0

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
        self._endings: list[tuple[Callable[[], None], bool]] = []

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
        """Tells this browser from the others."""
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

    def unseen(self, pressed: Callable[[], object]) -> str:
        """The id of a button for HTML to press; see `tables`.  `hide` takes it out of sight."""
        button = self.gui.add_button("·")

        @button.on_click
        def _(_: Any) -> None:
            pressed()

        return element_id(button)

    def hide(self, buttons: Iterable[str]) -> None:
        """Take unseen buttons, and the room they would have, out of sight."""
        rules = ",".join(f'div:has(> [id="{button}"])' for button in buttons)
        self.gui.add_html(f'<style class="wb-style">{rules}{{display:none}}</style>')

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
            if not (in_scene and is_gone):
                action()

    def lacks(self, state: State, command: type) -> str:
        """Why a command of this type is not this person's now; empty when it is."""
        return lacks_right(state, command, self.person.name, self.person.role)

    def obstacle(self, state: State, command: type) -> str:
        """Why a command of this type from this browser is not in order now; empty when it is."""
        return self.lacks(state, command) or obstacle(state, command)

    def refusal(
        self,
        state: State,
        command: Command,
        now: float,
        joints: Mapping[str, float] = NOT_REPORTED,
    ) -> str:
        """Why the rules would refuse a command from this browser now; empty when they would not."""
        try:
            allowed(state, command, self.person.name, now, joints, self.person.role)
        except CommandRefused as error:
            return str(error)
        return ""

    def admit(
        self, control: Control, state: State, command: type, *, is_ready: bool = True
    ) -> None:
        """Let a control be used while its command is in order and everything else `is_ready`.

        When the command is not this person's, the control says why as its hint.
        """
        control.disabled = bool(self.obstacle(state, command)) or not is_ready
        self.explain(control, self.lacks(state, command))

    def explain(self, control: Control, problem: str) -> None:
        """Have a control say why it is not this person's; empty: what it said when it was made."""
        hint = self._hints.setdefault(id(control), control.hint)
        wanted = problem or hint
        if control.hint != wanted:
            control.hint = wanted

    def _may_steer(self, fields: Set[str]) -> bool:
        """Whether this person may change what everybody looks at.

        Those who approve have to play the plan, in control or not; viewers follow.
        """
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
        """Make a command and give it; a refusal is told in this browser only.

        Args:
            command: makes it.
            name: see `give`.

        Returns:
            Whether it was carried out.
        """
        try:
            self.give(command(), name)
        except WorkbenchError as error:
            self.tell("Refused", str(error))
        except Exception as error:
            # A rim: nothing that goes wrong for one browser may end the page for all.
            log.exception("a command from the page failed")
            self.tell("Internal error", f"{type(error).__name__}: {error}")
        else:
            return True
        return False

    def tell(self, title: str, text: str, *, color: Literal["red", "blue"] = "red") -> None:
        """Show a note in this browser; a red one when something did not happen."""
        self.client.add_notification(title, text, color=color, auto_close_seconds=SECONDS_TO_READ)


class Panel(Protocol):
    """The controls of one tab in one browser; holds handles and no values of the domain."""

    def show(self, old: View | None, new: View) -> None:
        """Bring what is shown from `old` (None: nothing yet) to `new`."""
        ...


def whole(value: Any) -> Any:
    """A number as an integer if it is one; anything else as it came, for the rules to refuse."""
    return int(value) if isinstance(value, float) and value.is_integer() else value
