"""`workbench session`: what sessions there are, what happened, and whether it can be trusted."""

import json
import time
from collections import Counter
from pathlib import Path
from typing import Any, assert_never

from workbench.app.records.session_archive import DATABASE, opened, told
from workbench.app.review.likeness import Likeness
from workbench.app.review.recompute import recomputed
from workbench.cli.arguments.nested import (
    SessionCommands,
    SessionExport,
    SessionImport,
    SessionList,
    SessionOpen,
    SessionPrune,
    SessionReplay,
    SessionShow,
    SessionVerify,
)
from workbench.cli.exits import NO_PLAN, SUCCESS
from workbench.cli.terminal import print_json, print_table
from workbench.journal.journal import Journal
from workbench.model.errors import JournalError


def session(typed: SessionCommands) -> int:
    """Carry out a command about sessions."""
    match typed.what:
        case SessionList():
            return _list(typed.what)
        case SessionShow():
            return _show(typed.what)
        case SessionVerify():
            return _verify(typed.what)
        case SessionReplay():
            return _replay(typed.what)
        case SessionOpen():
            from workbench.cli.serving.open_session import open_session

            return open_session(typed.what)
        case SessionExport():
            from workbench.cli.sessions.files import export

            return export(typed.what)
        case SessionImport():
            from workbench.cli.sessions.files import import_

            return import_(typed.what)
        case SessionPrune():
            from workbench.cli.sessions.files import prune

            return prune(typed.what)
        case _:
            assert_never(typed.what)


def _list(typed: SessionList) -> int:
    rows: list[tuple[str, ...]] = []
    if typed.sessions.is_dir():
        for folder in sorted(typed.sessions.iterdir()):
            if (folder / DATABASE).exists():
                rows.append(_summary(folder))
    if typed.json:
        keys = ("session", "cell", "entries", "ended", "message")
        print_json({"sessions": [dict(zip(keys, row, strict=True)) for row in rows]})
        return SUCCESS
    columns = ("session", "cell", "entries", "ended in", "what happened last")
    print_table(f"Sessions in {typed.sessions}", columns, rows)
    return SUCCESS


def _summary(folder: Path) -> tuple[str, ...]:
    try:
        journal = Journal(folder)
    except JournalError as error:
        return (folder.name, "", "", "", str(error))
    try:
        entries = list(journal.entries())
        first: Any = json.loads(entries[0].body) if entries else {}
        last: Any = json.loads(entries[-1].body).get("after", {}) if len(entries) > 1 else {}
        count = str(journal.count)
        return (
            folder.name,
            first.get("cell", ""),
            count,
            last.get("phase", "idle"),
            last.get("message", ""),
        )
    except (JournalError, ValueError) as error:
        return (folder.name, "", str(journal.count), "", str(error))
    finally:
        journal.close()


def _show(typed: SessionShow) -> int:
    journal = opened(typed.session)
    try:
        entries = told(journal).entries
    finally:
        journal.close()
    if typed.json:
        print_json({"entries": entries})
        return SUCCESS
    print_table(
        str(typed.session),
        ("#", "at (UTC)", "who", "what", "then", "says"),
        [
            (
                str(one["number"]),
                time.strftime("%Y-%m-%d %H:%M:%S", time.gmtime(one["at"] or 0)),
                one["actor"],
                one["kind"],
                one["phase"],
                one["message"],
            )
            for one in entries
        ],
    )
    return SUCCESS


def _verify(typed: SessionVerify) -> int:
    journal = opened(typed.session)
    try:
        problems = journal.verify()
        head, count = journal.head, journal.count
    finally:
        journal.close()
    for problem in problems:
        print(problem)
    if not problems:
        print(f"{typed.session}: {count} entries, unchanged since they were written; head {head}")
    return NO_PLAN if problems else SUCCESS


def _replay(typed: SessionReplay) -> int:
    journal = opened(typed.session)
    found: Counter[Likeness] = Counter()
    try:
        for one in recomputed(journal):
            found[one.likeness] += 1
            print(f"entry {one.number}, {one.task}: {one.says}", flush=True)
    finally:
        journal.close()
    if not found:
        said = "nothing that could be computed again"
    elif found[Likeness.OTHER]:
        said = f"computed again, {found[Likeness.OTHER]} of {found.total()} results differ"
    elif found[Likeness.WITHIN]:
        said = "computed again, every result is the same, or the same within tolerances"
    else:
        said = "computed again, every result is the same to the last digit"
    print(f"{typed.session}: {said}")
    return NO_PLAN if found[Likeness.OTHER] else SUCCESS
