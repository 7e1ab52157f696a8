"""What hands do on the page beside pressing buttons: find a point of the scene, drag, type."""

import math

import numpy as np
from playwright.sync_api import expect

from workbench.gui.scene import surroundings


class Camera:
    """Where points of the world are on the page."""

    def __init__(self, page, position, target):
        self.position = np.asarray(position)
        forward = (target - self.position) / np.linalg.norm(target - self.position)
        right = np.cross(forward, [0, 0, 1])
        right /= np.linalg.norm(right)
        self.axes = np.stack([right, np.cross(forward, right), forward])
        self.box = page.locator("canvas").first.bounding_box()

    def pixel(self, point) -> tuple[float, float]:
        x, y, z = self.axes @ (np.asarray(point) - self.position)
        focal = 0.5 * self.box["height"] / math.tan(surroundings.FIELD_OF_VIEW / 2)
        return (
            self.box["x"] + self.box["width"] / 2 + focal * x / z,
            self.box["y"] + self.box["height"] / 2 + focal * y / z,
        )


def first_look(page, cell) -> Camera:
    """The camera as the page looks at first."""
    return Camera(page, *surroundings.first_look(cell))


PAUSE = "ms => new Promise(done => setTimeout(done, ms))"


def pause(page, milliseconds):
    """Let so much time pass, and the page do what it had put off until then.

    The page sends values that change quickly a moment later; where it is slow that moment is over
    here and not there, and what is pressed next would come first.
    """
    page.evaluate(PAUSE, milliseconds)


FRAMES = "() => new Promise(done => {let n = 0; (function next() {"
FRAMES += "if (++n > 4) done(); else requestAnimationFrame(next);})();})"
"""Resolved when the page has drawn itself some times more: what was sent is where it is seen."""


def settle(page, milliseconds):
    """Let so much time pass, and as many pictures as it takes on a machine that draws slowly."""
    pause(page, milliseconds)
    page.evaluate(FRAMES)


def drag(page, start, end):
    """As a hand does it: there, down, along, up."""
    settle(page, 0)
    page.mouse.move(*start)
    settle(page, 300)
    page.mouse.down()
    settle(page, 100)
    page.mouse.move(*end, steps=12)
    settle(page, 200)
    page.mouse.up()


def unfold(screen, title: str) -> None:
    """Open a group of controls."""
    screen.page.get_by_text(title, exact=True).click()
    pause(screen.page, 400)


def row_of(screen, label: str):
    """What stands with a label; viser does not tie texts and sliders to theirs."""
    return screen.page.locator(
        f"//label[normalize-space(.)='{label}']/ancestor::*[.//input][1]"
    ).locator("visible=true")


def field(screen, label: str):
    """The input beside a label."""
    return row_of(screen, label).locator("input:visible").last


def slider_of(screen, label: str):
    """The slider beside a label."""
    return row_of(screen, label).get_by_role("slider")


def typed(screen, label: str, value: object) -> None:
    """Type a value into the input beside a label, and go on to the next one."""
    one = field(screen, label)
    one.fill(str(value))
    one.press("Tab")


def watch(screen, bench, wait) -> None:
    """Play the plan to its end, as soon as the page can: the last that is drawn of one is Play."""
    screen.wait_for("play it first")
    screen.tab("Plan")
    expect(screen.button("Play")).to_be_enabled()
    screen.tab("Cycle")
    screen.page.mouse.move(200, 400)
    screen.page.keyboard.press("k")
    wait(lambda: bench.state.watched, "the end of the plan")
