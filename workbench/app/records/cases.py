"""Failures of seeing that are kept: what a search found in a scan, and what a person says is there.

A case is one zip file with all that it takes to search again.  `case.json` is for people: who kept
it, why, what was found and what is there; `cell.json` and `scan.json` are the canonical forms of
both, and `files/` holds their large arrays by SHA-256 (`forms`).
"""

import json
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from workbench import __version__
from workbench.app.core.value_checks import (
    DETAIL,
    SEED_LIMIT,
    check_integer,
    check_near,
    check_number,
    check_text,
)
from workbench.app.records.forms import large_arrays, restore_value
from workbench.formats.files.archives import unpack, write_archive
from workbench.formats.files.whole_files import (
    MB,
    plain_name,
    read_whole,
)
from workbench.model.cell import Cell
from workbench.model.digest import FactsRepr, canonical, digest_of
from workbench.model.errors import FileError, InputError, WorkbenchError
from workbench.model.messages.commands import NameText
from workbench.model.messages.files import FileProblem
from workbench.model.scan import Detection, Scan, SearchRecord

FORMAT = "workbench-case/1"

LARGEST_CASE = 1024 * MB
"""[bytes] A case has, unpacked: about 25 million points."""

LARGEST_FORM = 64 * MB

UNREADABLE = (
    *(ArithmeticError, AttributeError, LookupError, RuntimeError, TypeError, ValueError),
    WorkbenchError,
)
"""What comes of a case whose content is not that of one."""


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Case(FactsRepr):
    """What a search found in a scan, and what a person says lies there.

    `at` [s since the epoch] `by` somebody, whose `comment` says what was wrong.  `search` is what
    the localizer brought in `scan` with the parts of `cell`, `truth` what lies there: parts found
    that were left alone, those that were corrected, and those that were missed.  `is_complete`:
    nothing else lies there.  `workbench` is the version that searched.
    """

    at: float
    by: str
    comment: str
    is_complete: bool
    cell: Cell
    scan: Scan
    search: SearchRecord
    truth: tuple[Detection, ...]
    workbench: str = __version__

    @property
    def changed(self) -> tuple[Detection, ...]:
        """What was found and people have not left so: it was called wrong, or moved."""
        there = {digest_of(detection) for detection in self.truth}
        return tuple(
            detection for detection in self.search.detections if digest_of(detection) not in there
        )

    @property
    def facts(self) -> Mapping[str, object]:
        """What people want to know of it."""
        found, changed, there = (
            len(some) for some in (self.search.detections, self.changed, self.truth)
        )
        origin = {"cell": self.cell.name, "kept by": self.by, "comment": self.comment}
        return {**origin, "found": found, "of them changed": changed, "there": there}


def write_case(path: Path, case: Case) -> None:
    """Write a case into one file, which afterwards is there wholly or not at all.

    Raises:
        FileError: it cannot be written, or would be larger than what is read.
    """
    form = canonical(case)
    cell, scan = form.pop("cell"), form.pop("scan")
    head = {
        "format": FORMAT,
        **form,
        "cell_digest": case.cell.digest,
        "part_digests": {part.name: part.digest for part in case.cell.parts},
        "scan_digest": case.scan.digest,
    }
    content: dict[str, Path | bytes | memoryview] = {
        "case.json": json.dumps(head, indent=1, ensure_ascii=False).encode(),
        "cell.json": json.dumps(cell, ensure_ascii=False).encode(),
        "scan.json": json.dumps(scan).encode(),
    }
    arrays = large_arrays(case)
    content |= {f"files/{digest}": arrays[digest] for digest in sorted(arrays)}
    size = sum(len(data) for data in content.values() if not isinstance(data, Path))
    if size > LARGEST_CASE:
        sizes = {"size": f"{size / MB:.0f}", "most": f"{LARGEST_CASE / MB:.0f}"}
        raise FileError(path, FileProblem.CASE_TOO_LARGE(**sizes))
    write_archive(path, content)


def read_case(path: Path) -> Case:
    """A case from a file, if it is as it was kept.

    Raises:
        FileError: it is none, is damaged, or was changed since.
    """
    with tempfile.TemporaryDirectory() as place:
        names = unpack(path, Path(place), LARGEST_CASE)
        if "case.json" not in names:
            detail = "there is no case.json in it"
            raise FileError(path, FileProblem.NO_CASE(detail=detail))
        try:
            # Numbers that are none make digests that are others, and no warnings.
            with np.errstate(all="ignore"):
                return _read(Path(place))
        except FileError as error:
            detail = f"{Path(error.path).name} {error.problem}"
            raise FileError(path, FileProblem.NO_CASE(detail=detail)) from None
        except UNREADABLE as error:
            said = " ".join(str(error).split())[:200] or type(error).__name__
            raise FileError(path, FileProblem.NO_CASE(detail=said)) from None


def _read(place: Path) -> Case:
    def form(name: str) -> Any:
        return json.loads(read_whole(place / name, LARGEST_FORM))

    def array(digest: str) -> bytes:
        return read_whole(place / "files" / plain_name(digest), LARGEST_CASE)

    head = form("case.json")
    if head.get("format") != FORMAT:
        raise InputError(f"its format is {head.get('format')!r:.60}, not {FORMAT!r}")
    known = {field.name for field in fields(Case)}
    values = {name: value for name, value in head.items() if name in known}
    case: Case = restore_value(
        Case, {**values, "cell": form("cell.json"), "scan": form("scan.json")}, array
    )
    _check(case, head)
    return case


def _check(case: Case, head: Mapping[str, Any]) -> None:
    """Whether all of a case belongs together, and can be searched.

    Raises:
        WorkbenchError: it does not, or cannot.
    """
    for what, value in (("cell", case.cell), ("scan", case.scan)):
        if value.digest != head[f"{what}_digest"]:
            raise InputError(f"its {what} was changed after the case was kept")
    named: Sequence[tuple[str, Detection]] = [
        *(("found", detection) for detection in case.search.detections),
        *(("there", detection) for detection in case.truth),
    ]
    check_text("by", case.by)
    check_text("comment", case.comment)
    check_number("at", case.at, 0.0, 1e11, "s")
    check_integer("seed", case.search.seed, 0, SEED_LIMIT - 1)
    check_number("detail", case.search.overrides.detail, *DETAIL, NameText.OF_USUAL)
    check_number(NameText.LEAST_SCORE, case.search.overrides.least_score, 0.0, 1.0)
    check_near(NameText.SCANNER(), case.scan.T_world_scanner)
    for what, detection in named:
        case.cell.part(detection.part)
        check_near(f"a {detection.part} {what}", detection.T_world_part)
