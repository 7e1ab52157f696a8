"""`workbench session open`: the page on a recorded session, moment by moment."""

import logging

from workbench.app.history import History
from workbench.cli.exits import SUCCESS
from workbench.cli.nested_arguments import SessionOpen
from workbench.cli.serve import wait_for_the_end
from workbench.cli.session import opened
from workbench.cli.terminal import check_whole


def open_session(typed: SessionOpen) -> int:
    """Serve the page until SIGINT or SIGTERM."""
    check_whole("--port", typed.port, 0, 65535)
    logging.basicConfig(level=logging.WARNING, format="%(asctime)s %(name)s: %(message)s")
    journal = opened(typed.session)
    try:
        history = History(journal)

        from workbench.gui.server import serve

        page = serve(history, host=typed.host, port=typed.port)
        print(f"{typed.session}, {history.count} entries, to look at only: {page.url}", flush=True)
        wait_for_the_end()
        page.close()
    finally:
        journal.close()
    return SUCCESS
