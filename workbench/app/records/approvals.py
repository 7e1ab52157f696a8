"""Approvals on the command line, on record: which plan was shown to whom, and who let it out, once.

A page keeps this in its session.  A command ends before the next one begins, so that it stands in a
journal of its own, with the same chain of hashes; two commands at once cannot both write to it.
"""

import json
from collections.abc import Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from workbench.app.core.people import is_same_person
from workbench.journal.journal import Journal
from workbench.model.digest import canonical
from workbench.model.errors import CommandRefused, JournalError
from workbench.model.release import Approval, Receipt

SHOWN, APPROVAL, ENDED = "Shown", "Approval", "Ended"

CUT_SHORT = "the command was ended"
"""A problem: whether a message was under way then, nobody knows."""

ATTEMPTS = 5
"""How often an end is written; without it a plan counts as one that went out."""

SHORTEST = 12
"""Digits of a digest that a person repeats."""


@dataclass(frozen=True, slots=True)
class ApprovalRecord:
    """The record in a folder.

    Concurrency: any process may call anything; of two that write at once one is refused.
    """

    folder: Path

    def show(self, digest: str, actor: str, at: float, facts: Mapping[str, str]) -> None:
        """The facts of a plan were printed for a person; refused where it has gone out already.

        Args:
            digest: of the plan.
            actor: the person's name.
            at: seconds since the epoch.
            facts: that were printed, the controller's address among them.
        """
        with self._open() as journal:
            _refuse_second(_entries(journal), digest)
            form = {"plan_digest": digest, "actor": actor, "at": at, "facts": dict(facts)}
            journal.append(SHOWN, _bytes(form))

    def check_shown(
        self, digest: str, actor: str, now: float, valid: float, facts: Mapping[str, str]
    ) -> None:
        """Refuse a plan that has gone out, and a person who has not seen these facts lately.

        Args:
            digest: of the plan.
            actor: the person's name.
            now: seconds since the epoch.
            valid: seconds for which a person may act on what was shown.
            facts: as they are now, by name.

        Raises:
            CommandRefused: states what the person can do.
        """
        with self._open() as journal:
            entries = _entries(journal)
        _refuse_second(entries, digest)
        shown = [body for kind, body in entries if kind == SHOWN]
        mine = [
            view
            for view in shown
            if view["plan_digest"] == digest and is_same_person(view["actor"], actor)
        ]
        if not mine:
            raise CommandRefused(
                f"plan {digest[:SHORTEST]} was not shown to {actor}; "
                "give the command without --digest first, and read"
            )
        last = mine[-1]
        if not last["at"] <= now < last["at"] + valid:
            raise CommandRefused(
                f"plan {digest[:SHORTEST]} was shown to {actor} more than {valid / 60:g} minutes "
                "ago, or the clock was set back; give the command without --digest, and read again"
            )
        other = [name for name, value in facts.items() if last["facts"].get(name) != value]
        if other:
            raise CommandRefused(
                f"what was shown to {actor} is otherwise now ({', '.join(other).lower()}); "
                "give the command without --digest, and read again"
            )

    def take(self, *approvals: Approval) -> None:
        """Put an approval on record, once a plan; of a row that for each plan, or none of them.

        Raises:
            CommandRefused: one of the plans was let out before, or is being at this moment.
        """
        with self._open() as journal:
            entries = _entries(journal)
            for approval in approvals:
                _refuse_second(entries, approval.plan_digest)
            try:
                for approval in approvals:
                    journal.append(APPROVAL, _bytes(canonical(approval)))
            except JournalError as error:
                raise CommandRefused(
                    f"another command approves at this moment; nothing was sent ({error})"
                ) from error

    def end(self, approval: Approval, receipts: Sequence[Receipt], problem: str) -> None:
        """What became of an approval: what went out, and why it broke off if it did."""
        form = {"plan_digest": approval.plan_digest, "is_unwatched": approval.is_unwatched}
        form |= {"actor": approval.actor, "problem": problem, "receipts": canonical(receipts)}
        for left in reversed(range(ATTEMPTS)):
            try:
                with self._open() as journal:
                    journal.append(ENDED, _bytes(form))
                return
            except JournalError:
                # Another command wrote at the same moment: what follows comes after it.
                if not left:
                    raise

    def _open(self) -> closing[Journal]:
        return closing(Journal(self.folder))


def _entries(journal: Journal) -> list[tuple[str, dict[str, Any]]]:
    """All entries; refused when somebody has changed one of them."""
    problems = journal.verify()
    if journal.count == 0:
        # That there is no entry is one of them; entries that are gone are another.
        problems = problems[1:]
    if problems:
        raise CommandRefused(f"the record of approvals was changed: {problems[0]}")
    rows = list(journal.entries())
    if others := {row.kind for row in rows} - {SHOWN, APPROVAL, ENDED}:
        raise CommandRefused(
            f"{journal.folder}: is no record of approvals (it holds {min(others)}); see --record"
        )
    return [(row.kind, json.loads(row.body)) for row in rows]


def _refuse_second(entries: Sequence[tuple[str, dict[str, Any]]], digest: str) -> None:
    """Refuse a plan that was sent before, unless nothing of it has reached the controller."""
    taken = None
    for kind, body in entries:
        if body["plan_digest"] != digest:
            continue
        if kind == APPROVAL:
            taken = body
        elif kind == ENDED and not body["receipts"] and body["problem"] != CUT_SHORT:
            taken = None
    if taken is not None:
        raise CommandRefused(
            f"plan {digest[:SHORTEST]} was approved by {taken['actor']} before and has gone out; "
            "an approval moves the robot once: plan anew with another --seed"
        )


def _bytes(form: Mapping[str, Any]) -> bytes:
    return json.dumps(form, allow_nan=False).encode()
