"""What the style sheet tells beside viser's controls: hints of buttons, names of numbers."""

import pytest
from playwright.sync_api import Locator


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
