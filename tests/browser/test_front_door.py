"""Through the front with a real browser: in, out, and back again after a restart."""

from urllib.parse import urlsplit

import pytest
from front_page import Window, open_front
from playwright.sync_api import expect
from waiting import wait_until

from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.parts import FindParts
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.cycle.scanning import TakeScan
from workbench.app.core.cycle.sending import SendPlan
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.core.people import Role
from workbench.web.access.store import Store
from workbench.web.access.users import Users

PASSWORD = "correct horse battery"


@pytest.fixture
def file(tmp_path):
    return tmp_path / "users.sqlite"


@pytest.fixture
def users(file):
    store = Store(file)
    users = Users(store)
    users.add("Otto", Role.OPERATOR, PASSWORD)
    users.add("Vera", Role.VIEWER, PASSWORD)
    yield users
    store.close()


@pytest.fixture
def start(bench, file):
    """Starts a page with its front; both end with the test, or when they are closed."""
    ends = []

    def one(port=0):
        front, *both = open_front(bench, file, port)
        ends.extend(one.close for one in both)
        return front

    yield one, lambda: [end() for end in ends]
    for end in ends:
        end()


@pytest.fixture
def window(new_context):
    return Window(new_context())


def test_the_first_link_leads_to_the_page_and_nowhere_else(start, window, reaches, shots):
    front = start[0]()
    window.page.goto(front.link)
    window.sees_the_scene()
    expect(window.page.locator("header")).to_contain_text("operator engineer")
    window.page.wait_for_timeout(100)
    window.scan.click()
    reaches("scanned")
    window.page.screenshot(path=shots / "front.png")
    assert window.errors == []
    assert window.hosts <= {urlsplit(front.url).netloc, ""}


PIECES = """() => performance.getEntriesByType('resource')
    .filter(one => one.name.includes('/scene/pieces/') && one.responseEnd > 0)
    .map(one => one.transferSize)"""


def test_the_page_is_fetched_while_the_password_is_typed(users, start, window):
    front = start[0]()
    window.page.goto(front.url)
    wait_until(lambda: len(window.page.evaluate(PIECES)) == 6, "the pieces")
    assert all(size > 50_000 for size in window.page.evaluate(PIECES))
    window.log_in(front.url, "Otto", PASSWORD)
    window.sees_the_scene()
    scene = window.page.locator("#scene").element_handle().content_frame()
    # None of them came a second time.
    assert scene.evaluate(PIECES) == [0] * 6
    assert window.errors == []


def test_a_piece_that_was_cut_off_is_fetched_again_while_the_password_is_typed(
    users, start, window
):
    front = start[0]()
    broken = []

    def cut(route):
        # The first two, which are all that are asked for at the same time.
        if len(broken) < 2:
            broken.append(route.request.url)
            route.abort("connectionreset")
        else:
            route.continue_()

    window.page.route("**/scene/pieces/*", cut)
    window.page.goto(front.url)
    fetched = f"({PIECES})().filter(size => size > 50_000).length"
    wait_until(lambda: window.page.evaluate(fetched) == 6, "the pieces")
    assert len(set(broken)) == 2


def test_in_with_the_password_alone_and_out_again(users, start, window, shots):
    front = start[0]()
    window.log_in(front.url, "Otto", "not the password")
    alert = window.page.get_by_role("alert")
    expect(alert).to_have_text("Name or password is wrong.")
    window.page.screenshot(path=shots / "login.png")
    window.errors.clear()  # the browser notes the status 401 by itself
    window.log_in(front.url, "Otto", PASSWORD)
    window.sees_the_scene()
    expect(window.page.locator("header")).to_contain_text("Otto operator")
    window.page.get_by_role("button", name="Log out").click()
    window.page.get_by_label("Password").wait_for()
    window.page.goto(front.url)
    window.page.get_by_label("Password").wait_for()
    assert window.errors == []


def test_who_is_kept_out_is_at_the_login_at_once(users, start, window):
    front = start[0]()
    window.log_in(front.url, "Otto", PASSWORD)
    window.sees_the_scene()
    users.set_disabled("Otto", True)
    window.page.get_by_label("Password").wait_for()
    assert urlsplit(window.page.url).path == "/login"


def test_after_a_restart_the_page_comes_back_by_itself(users, start, window, reaches):
    begin, end = start
    front = begin()
    window.log_in(front.url, "Otto", PASSWORD)
    window.sees_the_scene()
    end()
    line = window.page.locator("#link")
    expect(line).to_contain_text("No connection")
    begin(port=urlsplit(front.url).port)
    expect(line).to_be_empty()
    # Controls of before are greyed out until the scene is connected again.
    expect(window.scan).to_be_enabled()
    window.scan.click()
    reaches("scanned")
    expect(window.page.locator("header")).to_contain_text("Otto operator")


def test_a_viewer_sees_the_scene(users, start, window):
    front = start[0]()
    window.log_in(front.url, "Vera", PASSWORD)
    window.scene.locator("canvas").first.wait_for()
    expect(window.page.locator("header")).to_contain_text("Vera viewer")
    assert window.errors == []


def test_the_frame_is_dark_when_the_scene_is(users, start, window):
    front = start[0]()
    window.log_in(front.url, "Otto", PASSWORD)
    window.sees_the_scene()
    root = window.page.locator("html")
    expect(root).to_have_attribute("data-scheme", "light")
    window.page.keyboard.press("l")
    expect(root).to_have_attribute("data-scheme", "dark")

    window.page.reload()
    window.sees_the_scene()
    expect(root).to_have_attribute("data-scheme", "dark")


def test_a_system_that_is_dark_gets_a_dark_page(users, start, new_context):
    front = start[0]()
    window = Window(new_context(color_scheme="dark"))
    window.log_in(front.url, "Otto", PASSWORD)
    window.sees_the_scene()
    root = window.scene.locator("html")
    expect(root).to_have_attribute("data-mantine-color-scheme", "dark")
    window.page.keyboard.press("l")
    expect(root).to_have_attribute("data-mantine-color-scheme", "light")
    window.page.reload()
    window.sees_the_scene()
    expect(root).to_have_attribute("data-mantine-color-scheme", "light")


def test_the_width_of_the_controls_and_their_size_are_remembered(users, start, window, wait):
    front = start[0]()
    window.log_in(front.url, "Otto", PASSWORD)
    window.sees_the_scene()
    page, panel = window.page, window.scene.locator(".mantine-ScrollArea-root:has(.wb-head)")

    def width():
        return panel.bounding_box()["width"]

    box, before = panel.bounding_box(), width()
    page.mouse.move(box["x"] - 1, box["y"] + 400)
    page.mouse.down()
    page.mouse.move(box["x"] - 121, box["y"] + 400, steps=6)
    page.mouse.up()
    wait(lambda: width() > before + 80, "wider controls")
    wider = width()
    touch = page.get_by_role("button", name="Touch")
    touch.click()
    scan = window.scene.get_by_role("button", name="Scan", exact=True)
    wait(lambda: scan.bounding_box()["height"] >= 44, "buttons for fingers")
    page.wait_for_timeout(500)
    page.reload()
    window.sees_the_scene()
    wait(lambda: abs(width() - wider) < 3, "the width that they had")
    wait(lambda: scan.bounding_box()["height"] >= 44, "buttons for fingers again")
    expect(touch).to_have_attribute("aria-pressed", "true")
    touch.click()
    wait(lambda: scan.bounding_box()["height"] < 44, "buttons for a mouse")
    assert window.errors == []


TABS = ("Cycle", "Candidates", "Plan", "Robot")
SIZES = ((1280, 720), (1920, 1080), (1024, 700))


def sent(bench, reaches):
    """A plan on its way to the robot."""
    for command, phase in ((TakeScan(), "scanned"), (FindParts(), "localized")):
        bench.do(command, "Otto")
        reaches(phase)
    bench.do(MakePlan(), "Otto")
    digest = reaches("planned").plan.digest
    for command in (WatchPlan(digest), Approve(digest), SendPlan(digest)):
        bench.do(command, "Otto")


@pytest.mark.parametrize("speed", [0.1])
def test_stop_robot_fault_and_mode_are_at_the_same_place_on_every_tab_and_at_every_size(
    users, start, window, bench, robot, reaches, wait, shots
):
    """At 1280 x 720 the Stop of the Cycle tab was out of sight on all other tabs."""
    front = start[0]()
    window.log_in(front.url, "Otto", PASSWORD)
    window.sees_the_scene()
    page, stop = window.page, window.page.locator("#stop")
    expect(stop).to_be_disabled()
    expect(page.locator("#robot")).to_have_text("Simulated robot: stands")
    expect(page.locator("#mode")).to_have_text("Live")
    sent(bench, reaches)
    wait(lambda: bench.live.link.step > 0, "the robot to move")
    expect(page.locator("#mode")).to_have_text("Robot moves")
    for width, height in SIZES:
        page.set_viewport_size({"width": width, "height": height})
        for tab in TABS:
            window.scene.get_by_role("tab", name=tab).click()
            box = stop.bounding_box()
            assert box["y"] + box["height"] <= 40 and width - box["x"] - box["width"] < 20
            expect(stop).to_be_enabled()
            # Steps and tabs stay, too, however far one scrolls.
            assert window.scene.locator(".wb-strip").bounding_box()["y"] < 120
    page.set_viewport_size({"width": 1280, "height": 720})
    stop.click()
    assert "the controller acknowledged the stop" in str(reaches("fault").fault)
    expect(page.locator("#fault")).to_contain_text("the controller acknowledged the stop")
    expect(stop).to_be_disabled()
    window.scene.get_by_role("tab", name="Cycle").click()
    # What is next after a stop stands in sight.
    box = window.scene.get_by_role("button", name="Acknowledge").bounding_box()
    assert box["y"] + box["height"] <= 720, "it is below the fold"
    page.screenshot(path=shots / "stopped-in-the-bar.png")
    # The button asks by two ways; the later one is told that there is nothing left to stop.
    assert [one for one in window.errors if "409 (Conflict)" not in one] == []
