"""Every command there is, by subject; a command that is not found here does not happen."""

from types import ModuleType

from workbench.app.core import control, drop_back, session, verifying
from workbench.app.core.cell import (
    bins,
    changes,
    emptying,
    kits,
    making,
    part_edits,
    recipes,
    views,
)
from workbench.app.core.command import Command
from workbench.app.core.cycle import (
    ahead,
    approval,
    correcting,
    empty_hand,
    jobs,
    outcomes,
    parts,
    planning,
    rows,
    scanning,
    sending,
    unapproved,
    watching,
)

SUBJECTS = (
    scanning,
    verifying,
    parts,
    planning,
    empty_hand,
    drop_back,
    rows,
    watching,
    approval,
    unapproved,
    sending,
    outcomes,
    ahead,
    jobs,
    changes,
    recipes,
    bins,
    views,
    kits,
    part_edits,
    making,
    correcting,
    emptying,
    control,
    session,
)


def commands_of(subject: ModuleType) -> tuple[type[Command], ...]:
    """The kinds of commands that a subject's file defines, in their order there."""
    return tuple(
        kind
        for kind in vars(subject).values()
        if isinstance(kind, type)
        and issubclass(kind, Command)
        and kind.__module__ == subject.__name__
    )


COMMANDS = tuple(kind for subject in SUBJECTS for kind in commands_of(subject))
