"""`workbench acceptance`: the record by which a cell is accepted, from its sessions."""

import time
from collections import deque
from contextlib import closing
from dataclasses import asdict
from pathlib import Path

from workbench.app.core.state import State
from workbench.app.evidence.acceptance import Targets, judge_acceptance, session_words
from workbench.app.evidence.pages import html_page, pdf_pages
from workbench.app.records.replay import replay
from workbench.app.records.session_archive import open_journal
from workbench.app.records.sessions import cell_of
from workbench.app.review.commissioning import checklist
from workbench.app.statistics.statistics import Statistics, statistics, together
from workbench.cli.arguments.upkeep import Acceptance
from workbench.cli.exits import FAILURE, SUCCESS
from workbench.cli.terminal import print_json, print_table
from workbench.formats.files.whole_files import write_whole
from workbench.model.errors import InputError, JournalError


def write_acceptance(typed: Acceptance) -> int:
    """Judge the picks and write the record; the exit code is 0 only when all targets are met."""
    targets = Targets(typed.picks, typed.share, typed.seconds)
    targets.check()
    read = [_read(folder) for folder in typed.sessions]
    if not read:
        raise InputError("name the folder of a session")
    names = sorted({state.cell.name for state, _, _ in read})
    if len(names) > 1:
        raise InputError(f"the sessions are of several cells: {', '.join(names)}")
    state, counted = read[-1][0], together(counted for _, counted, _ in read)
    now = time.time()
    judged = judge_acceptance(
        state,
        [says for _, _, says in read],
        checklist(state, counted, now),
        counted,
        targets,
        now,
    )
    is_pdf = typed.out.suffix.lower() == ".pdf"
    content = (
        pdf_pages(judged.title, judged.tables) if is_pdf else html_page(judged.title, judged.tables)
    )
    if content is None:
        raise InputError(f"{typed.out}: a PDF needs pip install 'workbench[evidence]'")
    write_whole(typed.out, content)
    result = judged.result
    if typed.json:
        rows = [dict(zip(("target", "agreed", "reached", "result"), row, strict=True))
                for row in result.rows]  # fmt: skip
        print_json({"ok": judged.is_met, "out": str(typed.out), **asdict(targets), "rows": rows})
    else:
        print_table(result.title, tuple(map(str.lower, result.columns)), result.rows)
        print(f"{typed.out}: the record, for signatures")
    return SUCCESS if judged.is_met else FAILURE


def _read(folder: Path) -> tuple[State, Statistics, str]:
    """The last state of a session, its statistics, and what identifies it.

    Raises:
        JournalError: it was changed, or cannot be computed again.
    """
    with closing(open_journal(folder)) as journal:
        if problems := journal.verify():
            raise JournalError(f"{folder}: {problems[0]}; a changed session shows nothing")
        moments = deque(replay(journal, cell_of(journal)), maxlen=1)
        if not moments:
            raise JournalError(f"{folder}: nothing happened in this session")
        (entry, state), counted = moments[0], statistics(journal.entries())
        return state, counted, session_words(folder.resolve().name, entry.number, journal.head)
