"""`workbench session export|import|prune`: sessions taken along, brought back, and removed."""

import re
import shutil
import sys
import time
from contextlib import closing
from datetime import UTC, datetime
from pathlib import Path

from workbench.app.core.state import State
from workbench.app.records.replay import replay
from workbench.app.records.session_archive import export_session, import_session, open_journal
from workbench.app.records.sessions import cell_of
from workbench.cli.arguments.session import SessionExport, SessionImport, SessionPrune
from workbench.cli.exits import SUCCESS
from workbench.cli.terminal import check_number, check_whole
from workbench.journal.journal import DATABASE, Journal
from workbench.model.errors import FileError, InputError, JournalError
from workbench.plugins.extras import from_extra

BY_TIME = re.compile(r"(\d{8}-\d{6})-.+", re.ASCII)
"""What `app.records.sessions` calls a folder."""

MEGABYTE = 2**20


def export(typed: SessionExport) -> int:
    """Write the zip file, or the one for Foxglove."""
    with closing(open_journal(typed.session)) as journal:
        if typed.mcap:
            from_extra("mcap.session:export_mcap")(journal, typed.out)
            return _report(typed.out)
        scene = None
        if not typed.no_scene and (state := _worth_seeing(journal)) is not None:
            # The page takes its time to import.
            from workbench.gui.page.recording import scene_html

            scene = scene_html(state)
        export_session(journal, typed.out, scene)
    return _report(typed.out)


def _report(out: Path) -> int:
    print(f"{out}: {out.stat().st_size / MEGABYTE:.1f} MB")
    return SUCCESS


def _worth_seeing(journal: Journal) -> State | None:
    """The last state with a plan; without one the last with a scan, or none."""
    best: State | None = None
    for _, state in replay(journal, cell_of(journal)):
        has_plan = best is not None and best.plan is not None
        if state.plan is not None or (state.scan is not None and not has_plan):
            best = state
    return best


def import_(typed: SessionImport) -> int:
    """Take the zip file, once it was checked."""
    folder = import_session(typed.file, typed.sessions)
    print(f"{folder}: whole, as it was exported")
    return SUCCESS


def prune(typed: SessionPrune) -> int:
    """Remove what is too old, when that is wanted."""
    if typed.keep is None and typed.older_than_days is None:
        raise InputError("say what to keep: --keep NUMBER, --older-than-days DAYS, or both")
    if typed.keep is not None:
        check_whole("--keep", typed.keep, 0, 1_000_000)
    if typed.older_than_days is not None:
        check_number("--older-than-days", typed.older_than_days, 0, 1e6)
    old = _old(typed, time.time())
    if not old:
        print("there is nothing to remove")
        return SUCCESS
    total = 0
    for folder in old:
        size = sum(file.stat().st_size for file in folder.rglob("*") if file.is_file())
        total += size
        print(f"{folder}: {size / MEGABYTE:.1f} MB")
    question = f"remove {len(old)} sessions and free {total / MEGABYTE:.1f} MB?"
    if not typed.yes:
        if not sys.stdin.isatty():
            raise InputError(f"{question} Nobody can be asked here: say --yes")
        if input(f"{question} [y/N] ").strip().lower() not in ("y", "yes"):
            print("nothing was removed")
            return SUCCESS
    for folder in old:
        try:
            with closing(Journal(folder)) as journal:
                journal.claim(time.time())
                shutil.rmtree(folder)
        except JournalError as error:
            raise FileError(folder, f"not removed: {error}") from None
        except OSError as error:
            raise FileError(folder, f"not removed: {error.strerror or error}") from None
    print(f"{len(old)} sessions removed, {total / MEGABYTE:.1f} MB freed")
    return SUCCESS


def _old(typed: SessionPrune, now: float) -> list[Path]:
    """The sessions that are neither among the newest, nor young enough, nor going on."""
    found: list[tuple[float, Path]] = []
    for file in typed.sessions.glob(f"*/{DATABASE}"):
        at = _began(file.parent)
        if at is not None:
            found.append((at, file.parent))
    found.sort(reverse=True)
    old = found[typed.keep or 0 :]
    if typed.older_than_days is not None:
        old = [(at, folder) for at, folder in old if at < now - typed.older_than_days * 86400]
    return [folder for _, folder in sorted(old) if not _goes_on(folder)]


def _began(folder: Path) -> float | None:
    """The time in a session's name [s since 1970]; None when there is none in it."""
    match = BY_TIME.fullmatch(folder.name)
    try:
        return (
            None
            if match is None
            else datetime.strptime(match[1], "%Y%m%d-%H%M%S").replace(tzinfo=UTC).timestamp()
        )
    except ValueError:
        return None


def _goes_on(folder: Path) -> bool:
    """Whether another program has the session open: then its log stays when we close ours."""
    try:
        Journal(folder).close()
    except JournalError:
        return True
    return (folder / f"{DATABASE}-wal").exists()
