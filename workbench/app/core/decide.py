"""Whether a command is allowed now, and how it changes the state: two pure functions.

    idle -> scanned -> localized -> planned -> approved -> sending -> done | fault

The same state and entry give the same result on every machine at any time.  So a journal of
entries is the history of states.
"""

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType

from workbench.app.core.cell.changes import change_whole
from workbench.app.core.command import Asked, Command, Decision, Entry, refuse
from workbench.app.core.people import MACHINES, Role
from workbench.app.core.rights import lacks_right, lacks_role, obstacle
from workbench.app.core.state import State
from workbench.app.core.value_checks import check_person
from workbench.model.errors import CommandRefused, NotAllowed
from workbench.model.messages.refusals import Refusal

NOT_REPORTED: Mapping[str, float] = MappingProxyType({})


def check_allowed(
    state: State,
    command: Command,
    actor: str,
    now: float,
    joints: Mapping[str, float] = NOT_REPORTED,
    role: Role = Role.ENGINEER,
) -> None:
    """Check that a command is allowed now.

    Args:
        state: as it is.
        command: what is asked for.
        actor: who asks: a person's name, or one of `MACHINES`.
        now: seconds since the epoch.
        joints: how the robot stands by its own report, name -> [rad]; empty when it reports none.
        role: of the person who asks; that of somebody at the machine's own shell is engineer.

    Raises:
        CommandRefused: with a sentence for the one who asked; `NotAllowed` when it is a matter of
            the role alone.
    """
    kind = type(command)
    _check_actor(command, actor)
    if actor not in MACHINES and (problem := lacks_role(kind, role)):
        raise NotAllowed(problem)
    refuse(lacks_right(state, kind, actor, role))
    refuse(obstacle(state, kind))
    command.check(state, Asked(actor, now, joints, role))


def decide(state: State, entry: Entry) -> Decision:
    """The state after an entry, and what has to be set in motion.

    Args:
        state: before.
        entry: a command that `check_allowed` lets pass in this state.

    Raises:
        CommandRefused: an approval that `approval.approve` does not give.
    """
    command, state = entry.command, replace(state, number=entry.number)
    if command.right.changes_cell:
        return change_whole(state, lambda whole: command.apply(whole, entry))
    return command.apply(state, entry)


def _check_actor(command: Command, actor: str) -> None:
    right = command.right
    if right.by_machine and actor not in MACHINES:
        raise CommandRefused(Refusal.MACHINES_ONLY(command=right.says(), person=repr(actor)))
    is_allowed = (right.by_anybody and actor in MACHINES) or actor == right.also_by
    if not right.by_machine and not is_allowed:
        check_person(actor)
