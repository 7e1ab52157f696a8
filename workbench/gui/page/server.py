"""The page: one server, one thread that draws, a set of controls for each browser."""

from collections.abc import Mapping
from pathlib import Path

import viser

from workbench.app.review.history import History
from workbench.app.runtime.bench import Bench
from workbench.formats.files.shipped import find
from workbench.gui.page.patience import Patience
from workbench.gui.page.renderer import Renderer
from workbench.gui.page.theme import Theme
from workbench.gui.shared.viser_server import close_viser, open_viser
from workbench.model.prediction import Predictions

PANEL_WIDTH = 500
"""Of the controls beside the scene, in pixels."""

STYLES = ("page.css", "tables.css", "panel.css")

MOST_POINTS = 60_000
"""Of a scan on screen."""


class Page:
    """The page of one bench.

    Lifetime: from `serve` until `close`; the bench outlives it.
    """

    def __init__(self, url: str, server: viser.ViserServer, renderer: Renderer, patience: Patience):
        """Made by `serve`."""
        self.url = url
        self._server = server
        self._renderer = renderer
        self._patience = patience

    def close(self) -> None:
        """Cut off the browsers and stop listening; twice does no harm."""
        self._patience.close()
        if self._renderer.close():
            close_viser(self._server)


def serve(
    bench: Bench | History,
    *,
    host: str = "127.0.0.1",
    port: int = 8080,
    most_points: int = MOST_POINTS,
    predictions: Predictions | None = None,
    folders: Mapping[str, Path] | None = None,
    secret: str | None = None,
) -> Page:
    """Serve the page of a bench.

    Returns at once; the page lives in threads of its own.

    Args:
        bench: whose state is shown, and which takes the commands; or a recorded session.
        host: address to listen on.
        port: 0 takes a free one.
        most_points: of a scan to draw; slow browsers like fewer.
        predictions: what a study says about the threshold.
        folders: where the parts lie, by name.
        secret: without which nothing is answered, for a page that a front stands before.

    Raises:
        InputError: the address cannot be had.
        FileError: the style sheet or the logo is missing.
    """
    style = "".join(find("static", name).read_text(encoding="utf-8") for name in STYLES)
    theme = Theme(is_framed=secret is not None)
    server = open_viser(host, port, secret)
    try:
        theme.apply(server.gui, is_dark=False)
        server.gui.main_panel.dock_right()
        server.gui.main_panel.set_width(PANEL_WIDTH)
        renderer = Renderer(
            server,
            bench,
            theme,
            style=style,
            most_points=most_points,
            predictions=predictions,
            folders=folders or {},
        )
    except BaseException:
        close_viser(server)
        raise
    shown = "localhost" if host in ("0.0.0.0", "::") else host
    bracketed = f"[{shown}]" if ":" in shown else shown
    return Page(f"http://{bracketed}:{server.get_port()}", server, renderer, Patience(bench))
