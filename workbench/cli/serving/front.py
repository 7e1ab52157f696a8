"""The page of a bench with its front before it, as all commands serve it."""

import secrets
from collections.abc import Generator, Mapping
from contextlib import contextmanager
from pathlib import Path

from workbench.app.review.history import History
from workbench.app.runtime.bench import Bench
from workbench.cli.arguments.serving import Serve
from workbench.cli.arguments.session import SessionOpen
from workbench.cli.serving.ending import queue_end_signals
from workbench.cli.terminal import check_number, check_whole
from workbench.model.errors import InputError
from workbench.model.prediction import Predictions
from workbench.web.http.listening import TlsCertificate
from workbench.web.page.bar import bar_of, stop_of
from workbench.web.page.relay import Upstream
from workbench.web.server import Front, Routes, ServerOptions, serve_front


def front_options(typed: Serve | SessionOpen) -> ServerOptions:
    """What was typed about the front.

    Raises:
        InputError: it cannot be so.
    """
    check_whole("--port", typed.port, 0, 65535)
    check_number("--hours", typed.hours, 0.01, 24 * 31)
    certificate = None
    if typed.certificate is not None and typed.key is not None:
        certificate = TlsCertificate(typed.certificate, typed.key)
    elif typed.certificate is not None or typed.key is not None:
        raise InputError("--certificate and --key go together: one of them is missing")
    return ServerOptions(typed.host, typed.port, typed.name, certificate, typed.hours)


@contextmanager
def serve_with_front(
    bench: Bench | History,
    users: Path,
    options: ServerOptions,
    *,
    predictions: Predictions | None = None,
    folders: Mapping[str, Path] | None = None,
    routes: Routes = (),
) -> Generator[Front]:
    """Serve a page as long as the block runs.

    Args:
        bench: whose page; or a recorded session.
        users: file of users and logins.
        options: of the front.
        predictions: what a study says about the threshold.
        folders: where the parts lie, by name.
        routes: what the front serves beside the page.

    Raises:
        InputError: the address cannot be had.
        FileError: users, certificate or a page's file cannot be read.
    """
    # The page takes its time to import; whoever calls has begun by now what can go on beside.
    from workbench.gui.page.loading import loaded_ahead
    from workbench.gui.page.server import serve
    from workbench.gui.texts.page import PageText

    secret = secrets.token_urlsafe(32)
    page = serve(bench, port=0, predictions=predictions, folders=folders, secret=secret)
    try:
        title = PageText.CELL(name=bench.cell.name)
        front = serve_front(
            Upstream(page.url, secret),
            users,
            options,
            title=title,
            routes=routes,
            bar=bar_of(bench),
            stop=stop_of(bench),
        )
        try:
            with loaded_ahead():
                yield front
        finally:
            front.close()
    finally:
        page.close()


def wait_for_the_end(*lines: str) -> None:
    """Print that all is there, and return at SIGINT or SIGTERM."""
    signals = queue_end_signals()
    print(*lines, sep="\n", flush=True)
    signals.get()
