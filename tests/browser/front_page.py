"""The page as people come to it: behind the front, in the page around the scene."""

from pathlib import Path
from urllib.parse import urlsplit

from workbench.app.review.history import History
from workbench.gui.page.server import serve
from workbench.gui.texts.page import PageText
from workbench.web.access.identity import identify
from workbench.web.api.routes import api_routes
from workbench.web.api.taking_along import taking_along
from workbench.web.page.bar import bar_of, stop_of
from workbench.web.page.relay import Upstream
from workbench.web.server import ServerOptions, serve_front

SECRET = "a secret of this start"


def open_front(bench, file, port=0):
    """The front; and what has to be closed, in this order, it among them."""
    page = serve(bench, port=0, most_points=4000, secret=SECRET)
    front = serve_front(
        Upstream(page.url, SECRET),
        file,
        ServerOptions(port=port),
        title=PageText.CELL(name="tested"),
        routes=_routes(bench),
        bar=bar_of(bench),
        stop=stop_of(bench),
    )
    return front, front, page


def _routes(bench):
    """What `workbench serve` has beside the page; a recorded session has none of it."""
    if isinstance(bench, History):
        return ()
    return [*api_routes(bench, identify), *taking_along(bench.folder, Path.cwd())]


class Window:
    """One browser window, what it complained of and where it went."""

    def __init__(self, context):
        self.page = context.new_page()
        self.errors, self.hosts = [], set()
        self.page.on(
            "console",
            lambda message: message.type == "error" and self.errors.append(message.text),
        )
        self.page.on("pageerror", lambda error: self.errors.append(str(error)))
        self.page.on("request", lambda request: self.hosts.add(urlsplit(request.url).netloc))
        self.page.on("websocket", lambda socket: self.hosts.add(urlsplit(socket.url).netloc))

    @property
    def scene(self):
        return self.page.frame_locator("#scene")

    @property
    def scan(self):
        return self.scene.get_by_role("button", name="Scan", exact=True)

    def log_in(self, url, name, password):
        self.page.goto(url)
        self.page.get_by_label("Name").fill(name)
        self.page.get_by_label("Password").fill(password)
        self.page.get_by_role("button", name="Log in").click()

    def sees_the_scene(self):
        self.scan.wait_for()
