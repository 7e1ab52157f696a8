"""What the style sheet tells beside viser's controls: hints of buttons, names of numbers."""

import pytest
from playwright.sync_api import Locator

WINDOWS = ((1280, 720), (1440, 900), (1920, 1080), (1024, 768))
"""[px] Windows of people."""

DRAWN_AT = """button => {
    const of = button.parentElement, text = getComputedStyle(of, "::after");
    const place = name => parseFloat(text[name]);
    const panel = document.querySelector(".mantine-ScrollArea-root:has(.wb-head)");
    return {
        right: innerWidth - place("right"), left: place("left"),
        top: place("top"), bottom: innerHeight - place("bottom"),
        panel: panel.getBoundingClientRect().left, height: innerHeight,
    };
}"""
"""Where a button's text is drawn, and where the panel begins [px]."""


def told(element: Locator, beside: str) -> str:
    """What is drawn beside an element, as the browser has it."""
    return element.evaluate(f"one => getComputedStyle(one, '::{beside}').content").strip('"')


@pytest.mark.extensive
def test_a_grey_button_says_what_is_missing_and_each_number_which_it_is(screen, wait):
    box = screen.button("Plan").locator("..")
    assert told(box, "after") == "none"
    says = "Planning is not possible now: take a scan first"

    def is_hinted():
        # What is still being laid out may move away from under the pointer.
        box.hover(force=True)
        return told(box, "after") == says

    wait(is_hinted, "the hint of a grey button")
    box = screen.button("Scan").locator("..")
    box.hover()
    assert "none" in told(box, "after"), "nobody has written a hint for it"

    screen.tab("Cell")
    screen.wait_for("Position [mm]")
    for label, names in (("Position [mm]", "xyz"), ("Angles [deg]", ("roll", "pitch", "yaw"))):
        row = screen.page.locator(
            f"//label[normalize-space(.)='{label}']/ancestor::*[.//input][1]"
        ).locator("visible=true")
        numbers = row.locator(".mantine-NumberInput-root")
        assert [told(numbers.nth(k), "before") for k in range(3)] == list(names)
    # A slider with a number beside it is no such row.
    screen.tab("Cycle")
    number = screen.page.locator(".mantine-Slider-root:visible + .mantine-NumberInput-root").first
    assert told(number, "before") == "none"
    assert screen.errors == []


@pytest.mark.extensive
def test_what_a_button_does_is_said_over_the_scene_and_covers_no_button_or_result(screen, wait):
    for width, height in WINDOWS:
        screen.page.set_viewport_size({"width": width, "height": height})
        for name in ("Plan", "Next cycle", "Send", "Cancel task"):
            button = screen.button(name).last

            def is_said(button=button):
                button.hover(force=True)
                return told(button.locator(".."), "after") != "none"

            wait(is_said, f"the text of {name}")
            drawn = button.evaluate(DRAWN_AT)
            assert 0 <= drawn["left"] < drawn["right"] < drawn["panel"], (name, width)
            assert 0 <= drawn["top"] < drawn["bottom"] <= drawn["height"], (name, width)
