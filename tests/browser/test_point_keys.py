"""A grasp is put on the surface by keys alone, in the page as people come to it, in Chromium."""

import re

import numpy as np
import pytest
from front_page import Window
from hands import pause
from playwright.sync_api import expect
from waiting import wait_until

PART = "keyed_cylinder"
POINT = re.compile(r"x (-?[\d.]+) mm, y (-?[\d.]+) mm, z (-?[\d.]+) mm")


@pytest.fixture
def window(front, new_context):
    window = Window(new_context())
    window.page.goto(front.link)
    window.sees_the_scene()
    window.scene.get_by_role("tab", name="Grasps").click()
    window.scene.get_by_role("button", name="Add grasp", exact=True).press("Enter")
    return window


def test_arrow_keys_move_the_point_and_enter_puts_a_grasp_there(window, bench, shots):
    page, scene = window.page, window.scene
    box, said = scene.locator(".wb-point"), scene.locator(".wb-said")
    expect(box).to_be_focused()
    expect(said).to_have_text(POINT)
    assert said.evaluate("one => one.parentElement.ariaLive") == "polite"

    def point():
        return np.array([float(value) for value in POINT.search(said.inner_text()).groups()])

    def after(key):
        before = point()
        page.keyboard.press(key)
        wait_until(lambda: not np.array_equal(point(), before), f"the point after {key}")
        return np.linalg.norm(point() - before)

    pause(page, 300)
    assert 1.9 < after("ArrowUp") < 8
    page.screenshot(path=shots / "point-keys.png")
    pause(page, 300)
    assert 0.1 < after("Shift+ArrowLeft") < 0.9
    expect(box).to_be_focused()
    marked = point()
    pause(page, 300)
    page.keyboard.press("Enter")

    def added():
        return [one for one in bench.state.cell.part(PART).library.entries if one.name == "grasp"]

    wait_until(added, "the grasp")
    expect(box).to_have_count(0)
    T_part_tcp = added()[0].T_part_tcp
    away = marked / 1000 - T_part_tcp.translation
    across = away - T_part_tcp.rotation[:, 2] * (away @ T_part_tcp.rotation[:, 2])
    assert np.linalg.norm(across) < 0.002, "the hand comes in at the point"
    assert window.errors == []


def test_escape_puts_no_grasp_and_the_edge_of_the_part_is_told(window, bench):
    page, scene = window.page, window.scene
    entries = bench.state.cell.part(PART).library.entries
    expect(scene.locator(".wb-point")).to_be_focused()
    for _ in range(25):
        page.keyboard.press("ArrowLeft")
        pause(page, 80)
    expect(scene.locator(".wb-said")).to_contain_text("The part ends here.")
    page.keyboard.press("Escape")
    expect(scene.locator(".wb-point")).to_have_count(0)
    scene.get_by_role("button", name="Add grasp", exact=True).wait_for()
    assert bench.state.cell.part(PART).library.entries == entries
