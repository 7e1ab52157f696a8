"""Ends that have to be on record: tried again for as long as the journal cannot be written."""

import logging
import threading
from collections.abc import Callable

from workbench.app.core.command import Command
from workbench.app.core.state import State
from workbench.model.errors import CommandRefused, NotRecorded
from workbench.model.messages.message import Message

log = logging.getLogger(__name__)

RETRY = 1.0
"""[s] Between two tries."""


def insist(
    do: Callable[[Command, str], State],
    command: Command,
    actor: str,
    *,
    giving_up: threading.Event,
    show_problem: Callable[[Message | None], None],
    is_waiting: bool = False,
) -> None:
    """Have what has happened recorded, however long that takes: a disk may be full for a while.

    Args:
        do: takes the command.
        command: states what has happened.
        actor: the machine that reports it.
        giving_up: set when the bench closes; then it is tried no more.
        show_problem: called with why it is not on record yet, and with None that it is now.
        is_waiting: whether to try again as well while it is not in order, a task running say.

    Raises:
        Exception: what `do` raises besides `CommandRefused`.
    """
    has_shown = False
    while True:
        try:
            do(command, actor)
        except NotRecorded as error:
            if not has_shown:
                log.error("%s is not recorded yet: %s", type(command).__name__, error)
            has_shown = True
            show_problem(error.message)
            if not giving_up.wait(RETRY):
                continue
        except CommandRefused as error:
            if is_waiting and not giving_up.wait(RETRY):
                continue
            log.error("%s is not recorded: %s", type(command).__name__, error)
        if has_shown:
            show_problem(None)
        return
