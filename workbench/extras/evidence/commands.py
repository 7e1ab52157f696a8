"""`workbench evidence` and `workbench acceptance`: a session signed, a cell accepted."""

import time
from collections import deque
from contextlib import closing
from dataclasses import asdict
from hashlib import sha256
from pathlib import Path

from workbench.app.core.state import State
from workbench.app.records.replay import replay
from workbench.app.records.session_archive import open_journal
from workbench.app.records.sessions import cell_of
from workbench.app.review.commissioning import Targets
from workbench.app.statistics.statistics import Statistics, statistics, together
from workbench.cli.arguments.upkeep import Acceptance, Evidence
from workbench.cli.exits import FAILURE, SUCCESS
from workbench.cli.terminal import print_json, print_table, progress
from workbench.extras.evidence.acceptance import judge_acceptance, session_words
from workbench.extras.evidence.bundle import verify_script, write_bundle
from workbench.extras.evidence.packing import signed_message
from workbench.extras.evidence.pages import html_page, pdf_pages
from workbench.extras.evidence.signing import make_key, read_key, time_stamp_request
from workbench.formats.files.whole_files import write_whole
from workbench.model.errors import InputError, JournalError
from workbench.plugins.extras import install_command

KEY, SCRIPT = "key", "script"
"""What is typed in a session's place to have a key made, or verify.py written."""


def evidence(typed: Evidence) -> int:
    """Write the bundle, or a key."""
    if typed.session == KEY:
        return _key(typed)
    if typed.session == SCRIPT:
        return _script(typed)
    out = typed.out or Path("evidence.zip")
    key = None if typed.sign is None else read_key(typed.sign)
    with closing(open_journal(Path(typed.session))) as journal:
        if out.resolve().is_relative_to(journal.folder.resolve()):
            raise InputError(f"{out}: lies in the session; evidence of it goes elsewhere")
        with progress("evidence") as report:
            report(0.0, "the session is verified, computed again and packed")
            made = write_bundle(journal, out, time.time(), key)
    print(f"{out}: {made.entries} entries, head {made.head}")
    if key is None:
        print("not signed; `workbench evidence key` makes a key for --sign")
    else:
        print(f"signed; public key {key.public_key().public_bytes_raw().hex()}")
    if not made.has_pdf:
        print(f"without report.pdf, which needs {install_command('evidence')}")
    if typed.stamp:
        asked = out.with_suffix(".tsq")
        write_whole(asked, time_stamp_request(signed_message(made.manifest)))
        # What the request names, for whoever verifies the stamp.
        write_whole(out.with_suffix(".stamped"), signed_message(made.manifest))
        print(f"{asked}: the request for a time stamp of {out.with_suffix('.stamped')}")
    return SUCCESS


def _key(typed: Evidence) -> int:
    if typed.sign is not None or typed.stamp:
        raise InputError("a new key signs nothing yet: leave --sign and --stamp out")
    path = typed.out or Path("evidence.key")
    print(f"{path}: keep it where no one else can read it")
    print(f"public key, for those who verify: {make_key(path)}")
    return SUCCESS


def _script(typed: Evidence) -> int:
    if typed.sign is not None or typed.stamp:
        raise InputError("verify.py is not signed: leave --sign and --stamp out")
    path = typed.out or Path("verify.py")
    if path.exists():
        raise InputError(f"{path}: is there already; nothing is overwritten")
    content = verify_script()
    write_whole(path, content)
    print(f"{path}: verifies bundles; SHA-256 {sha256(content).hexdigest()}")
    return SUCCESS


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
        counted,
        targets,
        now,
    )
    is_pdf = typed.out.suffix.lower() == ".pdf"
    content = (
        pdf_pages(judged.title, judged.tables) if is_pdf else html_page(judged.title, judged.tables)
    )
    if content is None:
        raise InputError(f"{typed.out}: a PDF needs {install_command('evidence')}")
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
