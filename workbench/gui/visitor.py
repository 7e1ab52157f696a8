"""One browser: whose it is, what it may ask, and how it hears that something is refused."""

import logging
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Protocol

import viser
from viser._messages import HotkeyKey

from workbench.app.bench import Bench
from workbench.app.commands import Command
from workbench.app.history import History
from workbench.app.rights import NOBODY
from workbench.app.rules import NOT_REPORTED, allowed
from workbench.app.state import State
from workbench.gui.look import SharedLook, View
from workbench.model.cell import Cell
from workbench.model.errors import CommandRefused, WorkbenchError
from workbench.model.prediction import Predictions

log = logging.getLogger(__name__)

SECONDS_TO_READ = 8.0


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
        self.gui = client.gui
        self.bench = bench
        self.look = look
        self.predictions = predictions
        self.folders: Mapping[str, Path] = folders or {}

    @property
    def cell(self) -> Cell:
        """The cell as it is now."""
        return self.bench.state.cell

    @property
    def number(self) -> int:
        """Tells this browser from the others."""
        return self.client.client_id

    def on_press(self, button: viser.GuiButtonHandle, command: Callable[[], Command]) -> None:
        """Have a button give the command that is made when it is pressed."""

        @button.on_click
        def _(_: Any) -> None:
            self.ask(command)

    def on_key(self, key: HotkeyKey, says: str, pressed: Callable[[], object]) -> None:
        """Have a key do something while no field is typed in; listed by Ctrl+K.

        Nothing that lets a robot move has a key: that takes a hand on a button.
        """

        @self.gui.add_command(says, hotkey=key).on_trigger
        def _(_: Any) -> None:
            pressed()

    def give(self, command: Command, actor: str = NOBODY) -> None:
        """Give a command.

        Raises:
            CommandRefused: the rules do not allow it.
        """
        self.bench.do(command, actor)

    def ask(self, command: Callable[[], Command], actor: str = NOBODY) -> bool:
        """Make a command and give it; a refusal is told in this browser only.

        Returns:
            Whether it was carried out.
        """
        try:
            self.give(command(), actor)
        except WorkbenchError as error:
            self.tell("Refused", str(error))
        except Exception as error:
            # A rim: nothing that goes wrong for one browser may end the page for all.
            log.exception("a command from the page failed")
            self.tell("Internal error", f"{type(error).__name__}: {error}")
        else:
            return True
        return False

    def tell(self, title: str, text: str) -> None:
        """Show a note in this browser."""
        self.client.add_notification(title, text, color="red", auto_close_seconds=SECONDS_TO_READ)


class Panel(Protocol):
    """The controls of one tab in one browser; holds handles and no values of the domain."""

    def show(self, old: View | None, new: View) -> None:
        """Bring what is shown from `old` (None: nothing yet) to `new`."""
        ...


def refusal(
    state: State,
    command: Command,
    now: float,
    actor: str = NOBODY,
    joints: Mapping[str, float] = NOT_REPORTED,
) -> str:
    """Why the rules would refuse a command now; empty when they would not."""
    try:
        allowed(state, command, actor, now, joints)
    except CommandRefused as error:
        return str(error)
    return ""


def whole(value: Any) -> Any:
    """A number as an integer if it is one; anything else as it came, for the rules to refuse."""
    return int(value) if isinstance(value, float) and value.is_integer() else value
