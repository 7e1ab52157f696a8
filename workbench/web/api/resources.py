"""What can be read over HTTP: one table, a row an answer."""

import functools
import io
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from workbench.app.core.state import State
from workbench.app.review.commissioning import checklist
from workbench.app.runtime.bench import Bench
from workbench.app.statistics.statistics import Count, Statistics
from workbench.formats.plans.certificates import certificate_content
from workbench.formats.plans.plan_files import plan_content
from workbench.journal.journal import DATABASE
from workbench.model.digest import canonical
from workbench.model.scan import Scan
from workbench.web.api import forms, schemas

JSON = "application/json"


class AnswerSource:
    """What answers are made from.

    Lifetime: as long as the routes.

    Concurrency: any thread.
    """

    def __init__(self, bench: Bench):
        """Nothing is counted yet."""
        self.bench = bench
        self._count = Count()
        self._counting = threading.Lock()

    @property
    def state(self) -> State:
        """The newest state."""
        return self.bench.state

    @property
    def statistics(self) -> Statistics:
        """Of the session, counted on from where they were."""
        with self._counting:
            self._count.add(self.bench.entries(self._count.last))
            return self._count.value


@dataclass(frozen=True, slots=True)
class Read:
    """An answer to a GET of `path`; None is answered as not there, with what is `missing`."""

    path: str
    says: str
    answer: Callable[[AnswerSource], Any]
    schema: schemas.Schema
    missing: str = ""
    kind: str = JSON


def _scan(source: AnswerSource) -> Any:
    scan = source.state.scan
    return None if scan is None else forms.scan_form(scan)


def _points(source: AnswerSource) -> bytes | None:
    scan = source.state.scan
    return None if scan is None else _packed_points(scan)


# All clients share the bytes of a scan, which are tens of megabytes.
@functools.lru_cache(maxsize=1)
def _packed_points(scan: Scan) -> bytes:
    # Someone who has the points has what the digest is about.
    values: dict[str, Any] = {"points": scan.points}
    values["T_world_scanner"] = scan.T_world_scanner.homogeneous
    if scan.pixels is not None:
        values |= {"pixels": scan.pixels, "resolution": np.array(scan.resolution)}
    if scan.colours is not None:
        values["colours"] = scan.colours
    content = io.BytesIO()
    np.savez_compressed(content, **values)
    return content.getvalue()


def _detections(source: AnswerSource) -> Any:
    found = source.state.detections
    return None if found is None else [canonical(detection) for detection in found]


def _candidates(source: AnswerSource) -> Any:
    candidates = source.state.candidates
    return (
        None
        if candidates is None
        else [forms.candidate_form(candidate) for candidate in candidates]
    )


def _plan(source: AnswerSource) -> Any:
    state = source.state
    return None if state.plan is None else plan_content(state.plan, state.proof)


def _row(source: AnswerSource) -> Any:
    row = source.state.whole_row
    return (
        [plan_content(proven_plan.plan, proven_plan.proof) for proven_plan in row] if row else None
    )


def _proof(source: AnswerSource) -> Any:
    proof = source.state.proof
    return None if proof is None else forms.proof_form(proof)


def _certificate(source: AnswerSource) -> Any:
    plan, proof = source.state.plan, source.state.proof
    if plan is None or proof is None or not proof.holds:
        return None
    return certificate_content(plan, plan.scene, proof)


def _emptying(source: AnswerSource) -> Any:
    found = source.state.emptying
    return None if found is None else forms.emptying_form(found)


def _statistics(source: AnswerSource) -> Any:
    return forms.statistics_form(source.statistics)


def _commissioning(source: AnswerSource) -> Any:
    return forms.commissioning_form(checklist(source.state, source.statistics, time.time()))


def _sessions(source: AnswerSource) -> Any:
    folder = source.bench.folder
    beside = sorted(path.parent.name for path in folder.parent.glob(f"*/{DATABASE}"))
    return {"current": folder.name, "sessions": beside}


READS: tuple[Read, ...] = (
    Read(
        "/state",
        "Where the cycle stands.",
        lambda source: forms.state_form(source.state, source.bench.live),
        schemas.STATE,
    ),
    Read(
        "/jobs/current",
        "The running task and how far it is; null when none runs.",
        lambda source: forms.job_form(source.state, source.bench.live),
        schemas.JOB,
    ),
    Read("/scan", "The scan, without its points.", _scan, schemas.SCAN, "take a scan first"),
    Read(
        "/scan/points",
        "The scan as a NumPy archive: `points` (n, 3) [m] in the scanner's frame, "
        "`T_world_scanner`, and `pixels` with `resolution`, and `colours`, where the scanner "
        "gives them.",
        _points,
        {"type": "string", "format": "binary"},
        "take a scan first",
        "application/octet-stream",
    ),
    Read(
        "/detections",
        "The parts found.",
        _detections,
        schemas.DETECTIONS,
        "find the parts first",
    ),
    Read(
        "/candidates",
        "Every grasp of every part with every arm, and what became of it.",
        _candidates,
        schemas.CANDIDATES,
        "make a plan first",
    ),
    Read("/plan", "The plan, as its file has it.", _plan, schemas.PLAN, "make a plan first"),
    Read(
        "/row",
        "The plans of the row as their files have them, the first one first; `plan` is the one "
        "that is carried out now, or would be next.",
        _row,
        {"type": "array", "items": schemas.PLAN},
        "make a plan first",
    ),
    Read("/proof", "The proof of the plan.", _proof, schemas.PROOF, "make a plan first"),
    Read(
        "/proof/certificate",
        "The plan and its proof as a file that another machine checks: `workbench prove --check`.",
        _certificate,
        {"type": "object"},
        "make a plan whose proof holds first",
    ),
    Read(
        "/emptying",
        "What came of the piles that were emptied in simulation last.",
        _emptying,
        schemas.EMPTYING,
        "empty piles first",
    ),
    Read("/statistics", "What this session has brought.", _statistics, schemas.STATISTICS),
    Read(
        "/commissioning",
        "The steps from a new cell to its first pick, each checked.",
        _commissioning,
        schemas.COMMISSIONING,
    ),
    Read("/sessions", "This session and those beside it.", _sessions, schemas.SESSIONS),
)
"""Readable by every role; a viewer may look at everything."""
