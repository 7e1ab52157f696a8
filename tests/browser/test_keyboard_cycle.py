"""A whole cycle by keys alone, in the page as people come to it, in Chromium."""

import pytest
from front_page import Window
from hands import pause
from playwright.sync_api import expect
from waiting import wait_until

MOST_STOPS = 90
"""Of the Tab key, until a control has to be reached."""

FOCUSED = """() => {
  const inner = document.activeElement.contentDocument;
  const one = (inner ?? document).activeElement;
  const label = one.getAttribute("aria-label") ?? one.labels?.[0]?.innerText;
  return one.innerText?.trim() || label?.trim() || "";
}"""


@pytest.fixture
def window(robot, front, new_context):
    window = Window(new_context())
    window.page.goto(front.link)
    window.sees_the_scene()
    return window


def go_to(window, name):
    """Press Tab until the control of this name has the focus."""
    stops = []
    while len(stops) < MOST_STOPS:
        stops.append(window.page.evaluate(FOCUSED))
        if stops[-1] == name:
            return
        window.page.keyboard.press("Tab")
    raise AssertionError(f"{name} is not among the stops of the Tab key: {stops}")


def press(window, name):
    """Go to a button as soon as it can be pressed, and press it."""
    button = window.scene.get_by_role("button", name=name, exact=True).locator("visible=true")
    expect(button.first).to_be_enabled()
    # viser passes on one message each 50 ms.
    pause(window.page, 80)
    go_to(window, name)
    window.page.keyboard.press("Enter")


@pytest.mark.extensive
def test_a_cycle_from_scan_to_send_needs_no_pointer(window, bench, reaches, shots):
    press(window, "Scan")
    reaches("scanned")
    press(window, "Find parts")
    reaches("localized")
    press(window, "Plan")
    reaches("planned")
    press(window, "Play")
    wait_until(lambda: bench.state.watched, "the end of the plan")
    press(window, "Approve")
    expect(window.scene.get_by_role("dialog").get_by_label("Your name")).to_be_focused()
    window.page.keyboard.type("Ada", delay=100)
    window.page.screenshot(path=shots / "keyboard-approval.png")
    press(window, "Approve as Ada")
    assert reaches("approved").approval.actor == "Ada"
    press(window, "Send")
    assert reaches("done").parts_placed == 2
    assert window.errors == []
