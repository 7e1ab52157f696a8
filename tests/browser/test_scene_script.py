"""What the page around adds to the scene's page, for keyboards and for quick hands, in Chromium."""

import pytest
from front_page import Window
from hands import pause
from playwright.sync_api import expect
from test_shell import Shell
from waiting import wait_until

SCENE = """
<style>[aria-hidden=true] { display: none }</style>
<div class="wb-mode" data-mode="live"><b>Live</b></div>
<div class="mantine-Paper-root"><div class="mantine-Paper-root" id="heading" onclick="
  const body = this.nextElementSibling, is = body.getAttribute('aria-hidden') === 'true';
  body.setAttribute('aria-hidden', !is)">Saved<svg class="tabler-icon-chevron-down"></svg></div>
<div aria-hidden="true"><button>Save</button></div></div>
<div class="mantine-Flex-root"><p>Position</p><div class="mantine-Flex-root">
<div class="mantine-NumberInput-root"><input></div>
<div class="mantine-NumberInput-root"><input></div></div></div>
<style>.mantine-NumberInput-root + .mantine-NumberInput-root::before { content: "y" }</style>
<div id="host"></div>
<button onclick="hidden = true; other.hidden = false; said.textContent += 'Send '">Send</button>
<button id="other" hidden onclick="said.textContent += 'Go on '">Go on</button>
<p id="said"></p>
<div id="toasts"></div>
<div id="around"><button class="mantine-Button-root">Scan</button></div>
<input class="mantine-Select-input" readonly value="left trays of the second shift"
  style="width: 60px">
<div><div id="told"></div><div id="rows" style="height: 90px; overflow-y: auto">
<table class="wb-long-table"><tbody></tbody></table></div></div>
<script>
document.querySelector(".wb-long-table tbody").innerHTML = "<tr><td>a row</td></tr>".repeat(40);
function draw(chosen) {
  const row = (number) => `<tr tabindex="0" role="button" onclick="draw(${number})" onkeydown="
    if (event.key === 'Enter') draw(${number})">
    <td>row ${number}${number === chosen ? ' chosen' : ''}</td></tr>`;
  host.innerHTML = `<table><tbody>${[1, 2, 3].map(row).join("")}</tbody></table>`;
}
draw(0);
</script>
"""


@pytest.fixture
def stub(new_context):
    shell = Shell(new_context().new_page(), SCENE)
    scene = shell.page.frame_locator("#scene")
    expect(scene.locator("#heading")).to_have_attribute("aria-expanded", "false")
    expect(shell.page.locator("#wait")).to_be_hidden()
    shell.page.locator("#scene").focus()
    return shell.page, scene


def test_a_folded_group_opens_by_keyboard(stub):
    page, scene = stub
    page.keyboard.press("Tab")
    heading = scene.get_by_role("button", name="Saved")
    expect(heading).to_be_focused()
    page.keyboard.press("Enter")
    expect(heading).to_have_attribute("aria-expanded", "true")
    page.keyboard.press("Tab")
    expect(scene.get_by_role("button", name="Save", exact=True)).to_be_focused()
    page.keyboard.press("Shift+Tab")
    page.keyboard.press(" ")
    expect(heading).to_have_attribute("aria-expanded", "false")


def test_numbers_in_a_row_have_the_name_of_their_label_and_axis(stub):
    _, scene = stub
    expect(scene.get_by_label("Position y")).to_have_count(1)


def test_a_table_is_one_stop_and_its_rows_are_reached_by_arrows(stub):
    page, scene = stub
    rows = scene.locator("tbody tr")
    for _ in range(4):
        page.keyboard.press("Tab")
    expect(rows.first).to_be_focused()
    page.keyboard.press("ArrowDown")
    expect(rows.nth(1)).to_be_focused()
    page.keyboard.press("Enter")
    # The table is written anew, and the focus stays where it was.
    expect(rows.nth(1)).to_have_text("row 2 chosen")
    expect(rows.nth(1)).to_be_focused()
    page.keyboard.press("End")
    expect(rows.nth(2)).to_be_focused()
    page.keyboard.press("Tab")
    expect(scene.get_by_role("button", name="Send")).to_be_focused()


def test_the_second_click_of_a_double_click_presses_no_other_button(stub):
    page, scene = stub
    box = scene.get_by_role("button", name="Send").bounding_box()
    page.mouse.dblclick(box["x"] + 5, box["y"] + 5)
    expect(scene.get_by_role("button", name="Go on")).to_be_visible()
    assert scene.locator("#said").inner_text() == "Send"
    page.wait_for_timeout(600)
    scene.get_by_role("button", name="Go on").click()
    expect(scene.locator("#said")).to_have_text("Send Go on")


def test_a_field_that_is_too_narrow_says_all_that_is_chosen_in_it(stub):
    _, scene = stub
    field = scene.locator(".mantine-Select-input")
    field.hover()
    expect(field).to_have_attribute("title", "left trays of the second shift")
    field.evaluate("one => { one.style.width = '400px' }")
    scene.locator("#said").evaluate("said => { said.textContent = 'here' }")
    scene.locator("#said").hover()
    field.hover()
    expect(field).not_to_have_attribute("title", "left trays of the second shift")


def test_the_text_of_a_button_is_away_from_its_press_until_the_pointer_has_left_it(stub):
    _, scene = stub
    around, scan = scene.locator("#around"), scene.get_by_role("button", name="Scan")
    scan.click()
    expect(around).to_have_attribute("data-pressed", "")
    scan.evaluate("scan => { scan.disabled = true }")
    scan.hover(force=True)
    expect(around).to_have_attribute("data-pressed", "")
    scene.locator("#said").evaluate("said => { said.textContent = 'here' }")
    scene.locator("#said").hover()
    expect(around).not_to_have_attribute("data-pressed", "")


def test_a_row_that_is_chosen_stays_in_sight_where_its_table_gets_smaller(stub):
    _, scene = stub
    scene.locator("#rows").evaluate("one => { one.scrollTop = 200; }")
    row = scene.locator(".wb-long-table tr:nth-child(12)")
    rule = ".wb-long-table tr:nth-child(12){background:red}"
    scene.locator("#told").evaluate(
        """(one, rule) => { one.innerHTML = `<style class="wb-row-chosen">${rule}</style>`;
        document.getElementById("rows").style.height = "30px"; }""",
        rule,
    )

    def is_seen():
        inside, around = row.bounding_box(), scene.locator("#rows").bounding_box()
        ends = inside["y"] + inside["height"], around["y"] + around["height"]
        return around["y"] <= inside["y"] + 1 and ends[0] <= ends[1] + 1

    wait_until(is_seen, "the row in sight")


def test_all_groups_of_the_grasps_are_reached_and_opened_by_keyboard(front, new_context, shots):
    window = Window(new_context())
    window.page.goto(front.link)
    window.sees_the_scene()
    pause(window.page, 400)
    tab = window.scene.get_by_role("tab", name="Grasps")
    tab.click()
    heading = window.scene.get_by_role("button", name="Suggestions")
    expect(heading).to_have_attribute("aria-expanded", "false")
    tab.focus()
    focused = window.scene.locator(":focus")
    for _ in range(60):
        window.page.keyboard.press("Tab")
        if "Suggestions" in focused.inner_text():
            break
    expect(heading).to_be_focused()
    window.page.screenshot(path=shots / "keyboard-heading.png")
    window.page.keyboard.press("Enter")
    expect(heading).to_have_attribute("aria-expanded", "true")
    for _ in range(6):
        window.page.keyboard.press("Tab")
        pause(window.page, 50)
        if focused.evaluate("one => one.ariaLabel ?? one.labels?.[0]?.textContent") == "Seed":
            break
    expect(window.scene.get_by_label("Seed").locator("visible=true")).to_be_focused()
    for name in ("Position [mm] y", "Angles [deg] yaw"):
        expect(window.scene.get_by_label(name, exact=True)).to_have_count(1)
    assert window.errors == []


REFUSE = """
toasts.insertAdjacentHTML("beforeend", `<div class="mantine-Notification-root">
<div class="mantine-Notification-title">TITLE</div>
<div class="mantine-Notification-description">TEXT</div></div>`)
"""


def refuse(scene, title, text):
    """Has viser show a note as it does."""
    scene.locator("#toasts").evaluate(REFUSE.replace("TITLE", title).replace("TEXT", text))


def test_a_refusal_is_read_beside_the_field_that_was_typed_in_or_the_button_pressed(stub):
    page, scene = stub
    field, toasts = scene.locator(".mantine-NumberInput-root").first, scene.locator("#toasts")
    refuse(scene, "Refused", "nobody has typed")
    pause(page, 400)
    expect(toasts.get_by_text("nobody has typed")).to_be_visible()
    field.locator("input").press_sequentially("7")
    refuse(scene, "Refused", "7 mm is too wide")
    expect(field.locator(".wb-corrected")).to_have_text("7 mm is too wide")
    expect(toasts.get_by_text("7 mm is too wide")).to_be_hidden()
    scene.get_by_role("button", name="Scan").click()
    refuse(scene, "Refused", "a scan is under way")
    expect(scene.locator("#around .wb-corrected")).to_have_text("a scan is under way")
    refuse(scene, "Ada asks for control", "Hand over or Keep, in the panel.")
    pause(page, 400)
    expect(toasts.get_by_text("Hand over or Keep, in the panel.")).to_be_visible()
