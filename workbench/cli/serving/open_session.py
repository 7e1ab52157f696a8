"""`workbench session open`: the page on a recorded session, moment by moment."""

import logging

from workbench.app.records.session_archive import open_journal
from workbench.app.review.history import History
from workbench.app.runtime.readiness import make_ready
from workbench.cli.arguments.serving import Serve
from workbench.cli.arguments.session import SessionOpen
from workbench.cli.exits import SUCCESS
from workbench.cli.serving.front import front_options, serve_with_front, wait_for_the_end
from workbench.cli.terminal import progress
from workbench.journal.journal import Journal


def open_session(typed: SessionOpen) -> int:
    """Serve the page until SIGINT or SIGTERM."""
    logging.basicConfig(level=logging.WARNING, format="%(asctime)s %(name)s: %(message)s")
    return look_at(open_journal(typed.session), typed)


def look_at(journal: Journal, typed: SessionOpen | Serve) -> int:
    """Serve the page on what a journal holds by now, until SIGINT or SIGTERM, and close it."""
    options = front_options(typed)
    with progress("page") as report:
        make_ready(report, ("planning",))
    try:
        history = History(journal)
        with serve_with_front(history, typed.users, options) as front:
            entries = f"{history.count} entries, to look at only"
            wait_for_the_end(f"{journal.folder}, {entries}: {front.link}")
    finally:
        journal.close()
    return SUCCESS
