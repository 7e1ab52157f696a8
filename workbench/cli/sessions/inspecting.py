"""`workbench session`: what sessions there are, what happened, and whether it can be trusted."""

import json
import time
from collections import Counter
from contextlib import closing
from pathlib import Path
from typing import Any

from workbench.app.records.session_archive import list_session, open_journal
from workbench.app.review.likeness import Likeness
from workbench.app.review.recompute import recompute_tasks
from workbench.cli.arguments.session import SessionList, SessionReplay, SessionShow, SessionVerify
from workbench.cli.exits import NO_PLAN, SUCCESS
from workbench.cli.terminal import print_json, print_table
from workbench.formats.files.shipped import is_example_session
from workbench.formats.files.whole_files import MB, is_folder, read_whole
from workbench.journal.anchors import anchor_problems, anchors_from
from workbench.journal.journal import DATABASE, Journal
from workbench.model.errors import FileError, JournalError

LARGEST_ANCHORS = 64 * MB


def list_sessions(typed: SessionList) -> int:
    """List them, each with how it ended."""
    rows: list[tuple[str, ...]] = []
    if is_folder(typed.sessions):
        for folder in sorted(typed.sessions.iterdir()):
            if (folder / DATABASE).exists():
                name, *rest = summarize_session(folder)
                is_marked = is_example_session(folder) and not typed.json
                rows.append((f"{name} (shipped)" if is_marked else name, *rest))
    if typed.json:
        keys = ("session", "cell", "entries", "ended", "message")
        print_json({"sessions": [dict(zip(keys, row, strict=True)) for row in rows]})
        return SUCCESS
    columns = ("session", "cell", "entries", "ended in", "what happened last")
    print_table(f"Sessions in {typed.sessions}", columns, rows)
    return SUCCESS


def summarize_session(folder: Path) -> tuple[str, ...]:
    """The row of a session in the list: its first and its last entry say it, however long it is."""
    try:
        journal = Journal(folder)
    except JournalError as error:
        return (folder.name, "", "", "", str(error))
    try:
        begins, ends = next(journal.entries(), None), journal.last()
        first: Any = {} if begins is None else json.loads(begins.body)
        last: Any = {} if ends is None else json.loads(ends.body).get("after", {})
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


def show_session(typed: SessionShow) -> int:
    """Tell what happened, entry by entry."""
    with closing(open_journal(typed.session)) as journal:
        entries = list_session(journal).entries
    if typed.json:
        print_json({"entries": entries})
        return SUCCESS
    print_table(
        str(typed.session),
        ("#", "at (UTC)", "who", "what", "then", "says"),
        [
            (
                str(entry["number"]),
                time.strftime("%Y-%m-%d %H:%M:%S", time.gmtime(entry["at"] or 0)),
                entry["actor"],
                entry["kind"],
                entry["phase"],
                entry["message"],
            )
            for entry in entries
        ],
    )
    return SUCCESS


def verify_session(typed: SessionVerify) -> int:
    """Tell whether it was changed."""
    with closing(open_journal(typed.session)) as journal:
        problems = journal.verify()
        if typed.anchors is not None:
            problems = (*problems, *_unlike(journal, typed.anchors))
        head, count = journal.head, journal.count
    for problem in problems:
        print(problem)
    if not problems:
        print(f"{typed.session}: {count} entries, unchanged since they were written; head {head}")
    return NO_PLAN if problems else SUCCESS


def _unlike(journal: Journal, path: Path) -> tuple[str, ...]:
    """Where a journal is not the one whose heads were kept elsewhere."""
    try:
        anchors, torn = anchors_from(read_whole(path, LARGEST_ANCHORS).decode())
    except (TypeError, ValueError):
        raise FileError(path, "holds no anchors: a JSON object a line was expected") from None
    for remark in torn:
        print(remark)
    hashes = {row.number: row.hash for row in journal.entries()}
    return tuple(anchor_problems(hashes, journal.folder.resolve().name, anchors))


def replay_session(typed: SessionReplay) -> int:
    """Compute it again and compare."""
    found: Counter[Likeness] = Counter()
    with closing(open_journal(typed.session)) as journal:
        for comparison in recompute_tasks(journal):
            found[comparison.likeness] += 1
            print(f"entry {comparison.number}, {comparison.task}: {comparison.says}", flush=True)
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
