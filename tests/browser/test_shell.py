"""The bar above the scene, by itself: it hears from a server that is played here, in Chromium."""

import json
from pathlib import Path
from urllib.parse import urlsplit

import pytest
from playwright.sync_api import expect

STATIC = Path(__file__).resolve().parents[2] / "static"

KINDS = {
    ".css": "text/css",
    ".js": "text/javascript",
    ".svg": "image/svg+xml",
    ".woff2": "font/woff2",
}

STANDS = {"robot": "Robot: stands", "kind": "good", "fault": "", "has_robot": True}
SENDING = {**STANDS, "robot": "Sending: robot moving, step 1 of 9", "can_stop": True, "why": ""}
CANNOT = {"can_stop": False, "why": "nothing is sent"}
IDLE = {**STANDS, **CANNOT}


class Shell:
    """The page around the scene, and what it is told."""

    def __init__(self, page, scene=""):
        self.page, self._sockets, self._stops = page, [], []
        self._scene = scene
        page.route("**/*", self._answer)
        page.route_web_socket("**/presence", lambda socket: self._sockets.append(socket))
        page.goto("http://bar.test/")
        self.line, self.button = page.locator("#link"), page.locator("#stop")

    def _answer(self, route):
        path = Path(urlsplit(route.request.url).path)
        if path.name == "stop":
            self._stops.append(route)
        elif path.parent.name == "static":
            kind = KINDS[path.suffix]
            route.fulfill(body=(STATIC / path.name).read_bytes(), content_type=kind)
        elif path.name == "":
            shell = (STATIC / "shell.html").read_text(encoding="utf-8").replace("{{words}}", "{}")
            route.fulfill(body=shell, content_type="text/html")
        else:
            route.fulfill(body=self._scene, content_type="text/html")

    def _come(self, some):
        """The newest of what the page has opened or asked; the page may be told of it later."""
        while not some:
            self.page.wait_for_timeout(20)
        return some[-1]

    def hear(self, bar):
        self._come(self._sockets).send(json.dumps(bar))
        expect(self.page.locator("#robot")).to_have_text(bar["robot"])

    def refuse(self, why):
        # By both ways that the page asked by.
        expect(self.line).to_have_text("Stopping")
        self._come(self._stops).fulfill(status=409, body=json.dumps({"detail": why}))
        self._stops.clear()
        self._sockets[-1].send(json.dumps({"stopped": False, "why": why}))
        expect(self.line).to_have_text(f"Not stopped: {why}")


@pytest.fixture
def shell(new_context):
    return Shell(new_context().new_page())


def test_a_stop_that_did_not_work_is_said_as_long_as_it_could_be_tried_again(shell):
    shell.hear(SENDING)
    shell.button.click()
    shell.refuse("the link is gone")
    shell.hear({**SENDING, "robot": "Sending: robot moving, step 2 of 9"})
    expect(shell.line).to_have_text("Not stopped: the link is gone")
    shell.hear(IDLE)
    expect(shell.line).to_be_empty()


def test_a_stop_that_came_too_late_is_said_until_the_robot_does_something_else(shell):
    shell.hear(SENDING)
    shell.button.click()
    shell.hear(IDLE)
    shell.refuse("nothing is sent")
    shell.hear(IDLE)
    expect(shell.line).to_have_text("Not stopped: nothing is sent")
    shell.hear(SENDING)
    expect(shell.line).to_be_empty()


def test_a_fault_leaves_the_robots_words_and_the_name_of_the_cell_whole(shell):
    """At 1280 pixels the bar said `Robot: fa...` and `C...` beside two lines of a fault."""
    shell.page.set_viewport_size({"width": 1280, "height": 720})
    said = "sending was stopped at step 1 of 6; the controller acknowledged the stop after 0 ms; "
    said += "the robot was seen to stand 0.3 s later"
    shell.hear({**STANDS, "robot": "Robot: fault", "kind": "bad", "fault": said, **CANNOT})
    cut = "one => one.scrollWidth > one.clientWidth"
    assert not shell.page.locator("#robot").evaluate(cut)
    assert not shell.page.locator("header h1").evaluate(cut)
    assert shell.page.locator("#fault").bounding_box()["width"] >= 190


def test_of_two_presses_the_answer_to_the_last_one_stands(shell):
    shell.hear(SENDING)
    shell.button.click()
    first = shell._come(shell._stops)
    shell.button.click()
    while len(shell._stops) < 2:
        shell.page.wait_for_timeout(20)
    # Answers come in the order of the presses.
    shell._sockets[-1].send(json.dumps({"stopped": False, "why": "too early"}))
    shell._sockets[-1].send(json.dumps({"stopped": True, "why": ""}))
    expect(shell.line).to_be_empty()
    first.fulfill(status=409, body=json.dumps({"detail": "too early"}))
    shell.page.wait_for_timeout(200)
    expect(shell.line).to_be_empty()


def test_a_stop_that_worked_leaves_it_said_that_there_is_no_connection(shell):
    shell.hear(SENDING)
    shell._sockets[-1].close()
    expect(shell.line).to_contain_text("No connection")
    shell.button.click()
    expect(shell.line).to_have_text("Stopping")
    shell._come(shell._stops).fulfill(status=200, body="{}")
    expect(shell.line).to_contain_text("No connection")


def test_nobody_logs_out_while_the_robot_moves_or_for_good_without_being_asked(shell):
    out = shell.page.get_by_role("button", name="Log out")
    shell.hear(SENDING)
    expect(out).to_be_disabled()
    shell.hear(IDLE)
    expect(out).to_be_enabled()
    shell.page.locator("#leave-page").evaluate("form => { form.dataset.returns = 'false'; }")
    asked = []

    def refuse(dialog):
        asked.append(dialog.message)
        dialog.dismiss()

    shell.page.once("dialog", refuse)
    out.click()
    assert "Log out?" in asked[0] and shell.page.url == "http://bar.test/"
    shell.page.once("dialog", lambda dialog: dialog.accept())
    out.click()
    shell.page.wait_for_url("http://bar.test/logout")
