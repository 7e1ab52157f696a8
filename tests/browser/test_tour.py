"""The tour: once through a whole pick; and what it must not do, over a scene played here."""

import re

from front_page import Window
from hands import pause
from playwright.sync_api import expect
from test_shell import IDLE, SENDING, Shell
from waiting import wait_until

SCENE = """
<div class="wb-strip" style="position:fixed;left:800px;width:460px;top:0">1 2 3 4 5</div>
<div class="wb-mode" data-mode="live"><b>Live</b></div>
<div style="position:fixed;left:820px;top:200px"
  onclick="pressed.textContent += event.target.textContent">
<button role="tab">Cycle</button><button role="tab">Candidates</button>
<button>Scan</button><button>Find parts</button><button>Acknowledge</button><input id="field"></div>
<p id="pressed"></p>
"""


class Tour(Window):
    """A window with the tour in it."""

    def __init__(self, context, shots):
        super().__init__(context)
        self._shots = shots

    def at(self, title, name, role="button"):
        """It has come to this step, points at this control, and covers neither it nor Stop."""
        expect(self.page.locator("#title")).to_have_text(title)
        target = self.scene.get_by_role(role, name=name, exact=True).last
        self.frames(target)

        def leaves_the_rest_free():
            boxes = [self.page.locator(one).bounding_box() for one in ("#card", "#stop")]
            card, stop, strip = *boxes, self.scene.locator(".wb-strip").bounding_box()
            return (
                card
                and stop
                and strip
                and card["x"] >= 0
                and card["x"] + card["width"] <= strip["x"]
                and card["y"] >= stop["y"] + stop["height"]
                and card["y"] + card["height"] <= self.page.viewport_size["height"]
            )

        wait_until(leaves_the_rest_free, "a card that covers neither Stop nor the panel")
        self.page.screenshot(
            path=self._shots / f"tour-{re.sub(r'[^a-z]+', '-', title.lower())}.png"
        )
        return target

    def frames(self, target):
        """Has the ring around this."""
        ring = self.page.locator("#ring")

        def is_around():
            # Controls move, and the strip is drawn anew, while the page is still being built.
            inside, outside = target.bounding_box(), ring.bounding_box()
            return (
                inside
                and outside
                and abs(outside["x"] + 5 - inside["x"]) < 3
                and abs(outside["y"] + 5 - inside["y"]) < 3
                and abs(outside["width"] - 10 - inside["width"]) < 3
            )

        wait_until(is_around, f"the ring around {target}")

    def press(self, name, role="button"):
        # viser passes on one message each 50 ms.
        pause(self.page, 80)
        self.scene.get_by_role(role, name=name, exact=True).click()


def test_it_leads_through_a_pick_and_goes_on_when_something_was_really_done(
    front, new_context, bench, robot, reaches, wait, shots
):
    tour = Tour(new_context(), shots)
    page, keyboard = tour.page, tour.page.keyboard
    page.goto(front.link)
    expect(page.locator("#title")).to_have_text("Is this your first visit?")
    page.screenshot(path=shots / "tour-asked.png")
    # By keys alone, through the first two steps.
    tour.scan.wait_for()
    page.locator("#scene").focus()
    keyboard.press("t")
    expect(page.get_by_role("button", name="Begin")).to_be_focused()
    keyboard.press("Enter")
    tour.at("Scan", "Scan")
    assert bench.state.phase == "idle"
    keyboard.press("Enter")
    expect(tour.scan).to_be_focused()
    keyboard.press("Enter")
    reaches("scanned")
    find = tour.at("Find the parts", "Find parts")
    expect(page.get_by_role("button", name="Show me")).to_be_enabled()
    keyboard.press("t")
    expect(page.get_by_role("button", name="Show me")).to_be_focused()
    keyboard.press("Enter")
    expect(find).to_be_focused()
    keyboard.press("Enter")
    reaches("localized")

    tour.at("Look at the grasps", "Grasps", role="tab").click()
    tour.at("Look at the grasps", "Edit grasps").click()
    tour.at("Look at the grasps", "Back to cell").click()
    tour.at("Plan", "Cycle", role="tab").click()
    tour.at("Plan", re.compile("^Plan$")).click()
    reaches("planned")
    tour.at("See why grasps fail", "Candidates", role="tab").click()
    refused = tour.scene.locator(".wb-rows .wb-table tbody .wb-refused").first
    tour.frames(refused)
    assert tour.page.locator("#card").bounding_box()["height"] < 160, "over the sky of the scene"
    page.screenshot(path=shots / "tour-judge.png")
    refused.click()
    tour.at("Watch the preview", "Cycle", role="tab").click()
    tour.scene.locator("body").press("l")
    expect(page.locator("html")).to_have_attribute("data-scheme", "dark")
    tour.at("Watch the preview", re.compile("^Play$")).click()
    expect(page.locator("#title")).to_have_text("Watch the preview")
    wait(lambda: bench.state.watched, "the end of the plan")
    tour.at("Approve", re.compile("^Approve$")).click()
    dialog = tour.scene.get_by_role("dialog")
    dialog.locator("input").first.press_sequentially("Tamt", delay=100)
    tour.at("Approve", "Approve as Tamt")
    page.screenshot(path=shots / "tour-dialog.png")
    tour.press("Approve as Tamt")
    reaches("approved")
    assert robot.configurations == []
    tour.at("Send", re.compile("^Send$")).click()
    reaches("done")
    expect(page.locator("#title")).to_have_text("That was a pick")
    page.screenshot(path=shots / "tour-over.png")
    page.get_by_role("button", name="Close").click()

    # A second time it begins anew, and of its own accord never.
    page.reload()
    tour.scan.wait_for()
    expect(page.locator("#wait")).to_be_hidden()
    expect(page.locator("#card")).to_be_hidden()
    page.get_by_role("button", name="Tour").click()
    tour.at("Scan", "Scan")
    assert tour.errors == []


def test_who_leaves_it_is_not_asked_again_and_it_presses_nothing(new_context):
    shell = Shell(new_context().new_page(), SCENE)
    page, title = shell.page, shell.page.locator("#title")
    shell.hear({**IDLE, "tour": []})
    page.get_by_role("button", name="Begin").click()
    expect(title).to_have_text("Scan")
    shell.hear({**IDLE, "tour": ["scan"]})
    expect(title).to_have_text("Find the parts")
    # A scan again, another's fault: it follows, back as well.
    shell.hear({**IDLE, "tour": []})
    expect(title).to_have_text("Scan")
    shell.hear({**IDLE, "tour": [], "fault": "the link broke"})
    expect(title).to_have_text("A fault came up")
    shell.hear({**SENDING, "tour": ["scan", "find", "plan", "preview", "approve"]})
    expect(title).to_have_text("Send")
    scene = page.frame_locator("#scene")
    expect(scene.locator("#pressed")).to_be_empty()
    # What is typed is no key.
    page.get_by_role("button", name="Leave the tour").press("Escape")
    expect(page.locator("#card")).to_be_hidden()
    scene.locator("#field").press_sequentially("t")
    expect(page.locator("#card")).to_be_hidden()
    page.reload()
    shell.hear({**IDLE, "tour": []})
    expect(page.get_by_role("button", name="Tour")).to_be_visible()
    expect(page.locator("#wait")).to_be_hidden()
    expect(page.locator("#card")).to_be_hidden()
    scene.locator("#field").evaluate("field => field.blur()")
    scene.locator("body").press("t")
    expect(title).to_have_text("Scan")
    # Where there is none, there is no button either.
    shell.hear({**IDLE, "tour": None})
    expect(page.get_by_role("button", name="Tour")).to_be_hidden()
    expect(page.locator("#card")).to_be_hidden()


def test_it_goes_to_what_stands_there_now_and_not_to_what_is_greyed_out(new_context):
    shell = Shell(new_context().new_page(), SCENE)
    page, go = shell.page, shell.page.get_by_role("button", name="Show me")
    shell.hear({**IDLE, "tour": []})
    page.get_by_role("button", name="Begin").click()
    scan = page.frame_locator("#scene").get_by_role("button", name="Scan")
    scan.evaluate("scan => { scan.disabled = true }")
    expect(go).to_be_disabled()
    scan.evaluate("scan => { scan.disabled = false }")
    expect(go).to_be_enabled()
    # The page makes its buttons anew whenever it likes, also just before the key.
    go.evaluate(
        """go => {
            const scene = document.getElementById("scene").contentDocument;
            const buttons = [...scene.querySelectorAll("button")];
            const scan = buttons.find(one => one.textContent === "Scan");
            scan.replaceWith(scan.cloneNode(true));
            go.click();
        }"""
    )
    expect(scan).to_be_focused()


def test_a_button_of_the_card_that_is_pressed_stays_under_the_pointer(new_context):
    shell = Shell(new_context().new_page(), SCENE)
    page, card = shell.page, shell.page.locator("#card")
    shell.hear({**IDLE, "tour": []})
    page.get_by_role("button", name="Begin").click()
    everything = ["scan", "find", "plan", "preview", "approve", "send"]
    shell.hear({**IDLE, "tour": everything})
    expect(page.locator("#title")).to_have_text("That was a pick")
    legend = page.frame_locator("#scene").locator(".wb-mode")
    legend.evaluate("one => { one.style.width = '10rem'; }")
    expect(card).to_have_attribute("data-flat", "true")
    # The card glides to its place.
    page.wait_for_timeout(600)
    close = page.get_by_role("button", name="Close").bounding_box()
    page.mouse.move(close["x"] + 5, close["y"] + 5)
    page.mouse.down()
    # The legend gets wider: the card would go to the other side, below it.
    legend.evaluate("one => { one.style.width = '60vw'; }")
    page.wait_for_timeout(600)
    page.mouse.up()
    expect(card).to_be_hidden()
