"""Certificates of what was proven in a session, for who takes the session elsewhere."""

import json
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

from workbench.app.core.cycle.jobs import JobEnded
from workbench.app.core.session import Started
from workbench.app.provenance.inventory import Inventory
from workbench.app.records.forms import ReadFile, restore_value
from workbench.app.records.record import SESSION, entry_of
from workbench.formats.plans.certificates import LIBRARIES, certificate_bytes
from workbench.journal.journal import Row
from workbench.model.errors import JournalError, WorkbenchError
from workbench.model.plan import PlanResult, Proven

MadeWith = dict[str, str]


@dataclass(frozen=True, slots=True)
class Certified:
    """A plan whose proof holds: the entry that brought it, its digest, its certificate."""

    number: int
    digest: str
    certificate: bytes


def certificates(
    rows: Iterable[Row], read: ReadFile, *, only_approved: bool = False
) -> Iterator[Certified]:
    """The certificate of each plan whose proof holds, made with what the session says ran then.

    A plan that was made several times is certified where it came first.

    Args:
        rows: the entries of the session, in order.
        read: gives the files of its journal.
        only_approved: of plans that were approved only.

    Raises:
        JournalError: an entry cannot be read.
    """
    planned: list[tuple[Row, MadeWith]] = []
    approved: set[str] = set()
    made_with: MadeWith = {}
    for row in rows:
        try:
            body: Any = json.loads(row.body)
            if row.kind == SESSION:
                made_with = {"workbench": str(body["workbench"])}
            elif row.kind == Started.__name__:
                made_with = _made_with(restore_value(Inventory, body["command"]["ran"], read))
            elif row.kind == JobEnded.__name__ and "plan" in body["command"]["result"]:
                planned.append((row, made_with))
            if body.get("approval"):
                approved.add(body["after"]["plan"])
                approved |= {plan for plan, _ in body["approval"].get("row", ())}
        except (AttributeError, KeyError, TypeError, ValueError, WorkbenchError) as error:
            raise JournalError(f"entry {row.number} ({row.kind}) cannot be read") from error
    seen: set[str] = set()
    for row, made_with in planned if approved or not only_approved else ():
        entry, _ = entry_of(row.number, row.kind, row.body, read)
        result = entry.command.result if isinstance(entry.command, JobEnded) else None
        if not isinstance(result, PlanResult) or result.plan is None or result.proof is None:
            continue
        for proven_plan in (Proven(result.plan, result.proof), *result.row):
            digest = proven_plan.plan.digest
            is_wanted = digest in approved if only_approved else proven_plan.proof.holds
            if is_wanted and digest not in seen:
                seen.add(digest)
                content = certificate_bytes(
                    proven_plan.plan, proven_plan.plan.scene, proven_plan.proof, made_with
                )
                yield Certified(row.number, digest, content)


def _made_with(ran: Inventory) -> MadeWith:
    libraries = {distribution.name: distribution.version for distribution in ran.distributions}
    about = {"workbench": ran.workbench, "python": ran.python}
    about |= {"processor": ran.processor, "inventory": ran.digest}
    return about | {name: libraries.get(name, "unknown") for name in LIBRARIES}
