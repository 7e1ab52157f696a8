"""A session computed again from its journal, and checked against what was recorded."""

from collections.abc import Iterator
from dataclasses import replace

from workbench.app.core.command import Entry
from workbench.app.core.decide import check_allowed, decide
from workbench.app.core.state import State
from workbench.app.picking.facts import with_facts
from workbench.app.records.record import check_session, entry_of, summary
from workbench.journal.journal import Journal
from workbench.model.cell import Cell
from workbench.model.errors import CommandRefused, JournalError


def replay(
    journal: Journal, cell: Cell, *, is_judged: bool = True
) -> Iterator[tuple[Entry, State]]:
    """Every entry of a session with the state after it, in order.

    Args:
        journal: of the session.
        cell: that the session ran with.
        is_judged: whether the present rules must allow each entry.  A session that is continued
            is not judged, since stricter rules would end it for ever.

    Raises:
        JournalError: the session ran with another cell; an entry cannot be read, is against the
            rules, or gives a state other than the recorded one.
    """
    rows = journal.entries()
    first = next(rows, None)
    if first is None:
        raise JournalError(f"{journal.folder}: the session is empty")
    check_session(first.kind, first.body, cell)
    state = State(cell, number=first.number, saved=cell.digest)
    for row in rows:
        entry, recorded = entry_of(row.number, row.kind, row.body, journal.read)
        try:
            if is_judged:
                check_allowed(state, entry.command, entry.actor, entry.at, entry.joints, entry.role)
            state, _ = decide(state, replace(entry, command=with_facts(state, entry.command)))
        except CommandRefused as error:
            raise JournalError(
                f"entry {row.number} ({row.kind}) was not in order: {error}"
            ) from error
        computed = summary(state)
        for key, value in computed.items():
            # Another version may say the same in other words.
            if key != "message" and recorded.get(key) != value:
                raise JournalError(
                    f"entry {row.number} ({row.kind}) led to {key} {recorded.get(key)!r}, "
                    f"computed again it is {value!r}"
                )
        yield entry, state
