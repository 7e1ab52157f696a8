"""`workbench session open`: the page on a recorded session, moment by moment."""

import logging

from workbench.app.records.session_archive import opened
from workbench.app.review.history import History
from workbench.app.runtime.readiness import make_ready
from workbench.cli.arguments.nested import SessionOpen
from workbench.cli.exits import SUCCESS
from workbench.cli.serving.fronted import front_options, fronted
from workbench.cli.serving.serve import wait_for_the_end
from workbench.cli.terminal import progress


def open_session(typed: SessionOpen) -> int:
    """Serve the page until SIGINT or SIGTERM."""
    options = front_options(typed)
    logging.basicConfig(level=logging.WARNING, format="%(asctime)s %(name)s: %(message)s")
    with progress("page") as report:
        make_ready(report, ("planning",))
    journal = opened(typed.session)
    try:
        history = History(journal)
        with fronted(history, typed.users, options) as front:
            entries = f"{history.count} entries, to look at only"
            print(f"{typed.session}, {entries}: {front.link}", flush=True)
            wait_for_the_end()
    finally:
        journal.close()
    return SUCCESS
