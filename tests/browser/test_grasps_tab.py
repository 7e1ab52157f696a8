"""Grasps put on the part in a real browser: clicked, dragged, repeated, undone, saved, used."""

import os

import numpy as np
import pytest
import trimesh
from hands import Camera, drag, field, pause, settle, unfold

from workbench.formats.parts.reading import read_part
from workbench.formats.parts.saves import DRAFT, versions
from workbench.gui.grasps.pose import GIZMO
from workbench.gui.scene.stage import T_WORLD_STAGE, size_of, view_of
from workbench.model.part import GraspPattern

PART = "keyed_cylinder"


@pytest.fixture
def bench(own_bench):
    return own_bench


@pytest.fixture
def url(own_url):
    return own_url


def library(bench):
    return bench.state.cell.part(PART).library


def grasp(bench, name: str):
    return next(entry for entry in library(bench).entries if entry.name == name)


def stage_camera(screen, bench) -> Camera:
    settle(screen.page, 1500)
    return Camera(screen.page, *view_of(bench.state.cell.part(PART)))


def fill(screen, label: str, text: str) -> None:
    """Type as people do: not all at once, and done before the next thing is touched."""
    box = field(screen, label)
    box.fill(text)
    box.press("Tab")
    pause(screen.page, 200)


def test_the_hand_goes_from_copy_to_copy_and_a_grasp_to_an_offset(screen, bench, wait):
    screen.tab("Grasps")
    screen.press("Next copy")
    screen.wait_for("Copy 1 of 30")
    screen.button("Back to cell").wait_for()
    screen.press("Next copy")
    screen.wait_for("Copy 2 of 30")
    screen.page.locator("body").press("c")
    screen.wait_for("Copy 3 of 30, side-1-2: turned 72.0 deg, moved 28.0 mm")
    screen.shoot("grasps-copies")

    screen.press("Duplicate")
    wait(lambda: len(library(bench).entries) == 2, "the duplicate")
    authored, copy = library(bench).entries
    screen.page.get_by_text("Apply offset").scroll_into_view_if_needed()
    boxes = screen.page.locator(
        "//label[normalize-space(.)='Offset [mm]']/ancestor::*[.//input][1]//input"
    ).locator("visible=true")
    boxes.nth(0).fill("4")
    boxes.nth(0).press("Tab")
    screen.page.wait_for_timeout(300)
    screen.press("Apply offset")
    wait(lambda: 'at an offset from "side"' in str(bench.state.message), "the offset")
    T_side_copy = authored.grasp.T_part_tcp.actInv(grasp(bench, copy.name).grasp.T_part_tcp)
    assert np.allclose(T_side_copy.translation, (0.004, 0.0, 0.0), atol=1e-5)
    screen.press("Undo")
    wait(lambda: str(bench.state.message).startswith("undone"), "the undo")
    assert screen.errors == []


def test_a_grasp_is_made_with_the_mouse_and_picks_a_part(screen, bench, wait, reaches, own):
    screen.tab("Grasps")
    screen.press("Edit grasps")
    camera = stage_camera(screen, bench)

    # On the side of the body that faces the camera, between its end and the key.
    aim = np.array([0.65, -0.76, 0.0]) / np.linalg.norm([0.65, -0.76])
    point = np.array([0.0, 0.0, -0.012]) + 0.015 * aim
    screen.press("Add grasp")
    settle(screen.page, 300)
    screen.page.mouse.click(*camera.pixel(T_WORLD_STAGE.act(point)))
    wait(lambda: len(library(bench).entries) == 2, "the grasp that was clicked")
    made = grasp(bench, "grasp")
    z = made.T_part_tcp.rotation[:, 2]
    assert -z @ aim > np.cos(np.deg2rad(10)), "the tool comes in against the normal"
    tip = made.T_part_tcp.translation
    assert abs(tip[2] - point[2]) < 0.002
    assert 0.029 < made.grip < 0.031 and made.opening > made.grip
    screen.shoot("grasps-added")

    # Dragged along its own x, which lies along the part.
    x = made.T_part_tcp.rotation[:, 0]
    assert abs(x[2]) > 0.99
    size = size_of(bench.state.cell.part(PART))
    handle = T_WORLD_STAGE.act(tip + 0.9 * GIZMO * size * x)
    away = handle - np.array([0.0, 0.0, 0.01])
    drag(screen.page, camera.pixel(handle), camera.pixel(away))
    wait(lambda: "moved by the gizmo" in str(bench.state.message), "the drag")
    moved = grasp(bench, "grasp").T_part_tcp.translation - tip
    assert -0.013 < moved[2] < -0.007, moved
    assert np.abs(moved[:2]).max() < 0.0005
    assert np.allclose(grasp(bench, "grasp").T_part_tcp.rotation, made.T_part_tcp.rotation)

    # The thesis' 5 x 3 as one pattern, which stays editable.
    unfold(screen, "Copies and patterns")
    fill(screen, "Around [deg]", "5 x 72")
    fill(screen, "Along [mm]", "3 x 6 from -6")
    screen.press("Repeat")
    wait(lambda: isinstance(grasp(bench, "grasp"), GraspPattern), "the pattern")
    assert grasp(bench, "grasp").count == 15
    assert np.allclose(np.rad2deg(grasp(bench, "grasp").angles), [0, 72, 144, 216, 288])
    screen.wait_for("× 15")
    screen.shoot("grasps-pattern")

    screen.press("Undo")
    wait(lambda: not isinstance(grasp(bench, "grasp"), GraspPattern), "the undo")
    screen.press("Redo")
    wait(lambda: isinstance(grasp(bench, "grasp"), GraspPattern), "the redo")
    folder = own / "parts" / PART
    assert (folder / DRAFT).is_file()

    # The authored pattern is left out, so that what is planned is what was made here.
    screen.page.locator(".wb-list tbody tr").first.click()
    pause(screen.page, 400)
    screen.press("Delete")
    wait(lambda: [e.name for e in library(bench).entries] == ["grasp"], "the deletion")

    fill(screen, "Remark", "made with the mouse")
    screen.press("Save")
    wait(lambda: bench.state.saved == bench.state.cell.digest, "the saving")
    assert not (folder / DRAFT).exists()
    assert [one.remark for one in versions(folder)] == ["as it was before", "made with the mouse"]
    again = read_part(folder).library
    assert [(entry.name, entry.count) for entry in again.entries] == [("grasp", 15)]

    screen.page.reload()
    screen.button("Scan").wait_for()
    screen.press("Scan")
    reaches("scanned")
    screen.press("Find parts")
    reaches("localized")
    screen.press("Plan")
    state = reaches("planned")
    assert state.proof.holds
    assert {arm.grasp.split("-")[0] for arm in state.plan.arms} == {"grasp"}
    assert screen.errors == []


def test_two_browsers_edit_the_same_grasp_and_nothing_is_lost(open_screen, bench, wait):
    one, other = open_screen(), open_screen()
    for screen in (one, other):
        screen.tab("Grasps")
        unfold(screen, "How it takes the part")
    fill(one, "Opening [mm]", "44")
    fill(other, "Opening [mm]", "42")
    other.press("Apply")
    wait(lambda: "edited" in str(bench.state.message), "the quicker one")
    assert grasp(bench, "side").grasp.opening == pytest.approx(0.042)
    one.page.wait_for_timeout(500)
    one.press("Apply")
    one.wait_for("was changed by somebody else in the meantime")
    one.press("Keep mine")
    wait(lambda: len(library(bench).entries) == 2, "the copy")
    assert grasp(bench, "side").grasp.opening == pytest.approx(0.042)
    assert library(bench).entries[1].grasp.opening == pytest.approx(0.044)
    assert one.errors == other.errors == []


def test_what_a_tool_cannot_do_is_said_and_suggestions_are_taken(screen, bench, wait):
    screen.tab("Grasps")
    screen.wait_for("the smart_gripper can take it")
    unfold(screen, "How it takes the part")
    fill(screen, "Opening [mm]", "31")
    fill(screen, "Grip [mm]", "20")
    screen.press("Apply")
    wait(lambda: "edited" in str(bench.state.message), "the edit")
    screen.wait_for("the part is 30.0 mm wide between the fingers, the grip 20.0 mm")
    fill(screen, "Approach [mm]", "99999")
    screen.press("Apply")
    screen.wait_for("approach_length_mm: 99999 is not between 1 and 1000")
    unfold(screen, "Suggestions")
    screen.press("Suggest")
    screen.wait_for("suggested-1")
    screen.press("Take")
    wait(lambda: len(library(bench).entries) == 2, "the suggestion")
    screen.shoot("grasps-suggested")
    assert os.path.exists("parts")
    assert screen.errors == []


def test_a_cad_file_becomes_a_part_that_gets_a_grasp(screen, bench, wait, own):
    file = own / "brick.stl"
    trimesh.creation.box((40, 24, 20)).export(file)
    screen.tab("Grasps")
    unfold(screen, "New part from a CAD file")
    with screen.page.expect_file_chooser() as chooser:
        screen.press("Choose a CAD file")
    chooser.value.set_files(file)
    screen.wait_for(
        "brick.stl: 40 x 24 x 20 mm, assumed unit mm; z from -10 to 10 mm; closed, 19.2 cm³"
    )
    screen.wait_for("Mass: 23.04 g.")
    screen.press("Make the part")
    wait(lambda: "brick" in [part.name for part in bench.state.cell.parts], "the part")
    screen.wait_for("No grasps: plans search grasps")
    screen.press("Add grasp")
    settle(screen.page, 2000)
    part = bench.state.cell.part("brick")
    camera = Camera(screen.page, *view_of(part))
    screen.page.mouse.click(*camera.pixel(T_WORLD_STAGE.act(np.array([0.0, 0.0, 0.01]))))
    wait(lambda: bench.state.cell.part("brick").library.entries != (), "a grasp")
    screen.shoot("new-part")
    z = bench.state.cell.part("brick").library.grasps[0].T_part_tcp.rotation[:, 2]
    assert np.abs(z).max() > 0.999, "square on one of its faces"
    assert screen.errors == []


def test_one_of_several_solids_becomes_a_part(screen, bench, wait, own):
    scene = trimesh.Scene()
    plate = trimesh.creation.box((0.04, 0.024, 0.02))
    pin = trimesh.creation.cylinder(0.005, 0.03)
    pin.apply_translation((0.05, 0.0, 0.0))
    scene.add_geometry(plate, node_name="plate", geom_name="plate")
    scene.add_geometry(pin, node_name="pin", geom_name="pin")
    file = own / "set.glb"
    scene.export(file)
    screen.tab("Grasps")
    unfold(screen, "New part from a CAD file")
    with screen.page.expect_file_chooser() as chooser:
        screen.press("Choose a CAD file")
    chooser.value.set_files(file)
    screen.wait_for("set.glb: 75 x 24 x 30 mm, unit as the file states")
    screen.page.get_by_label("Solid", exact=True).click()
    screen.page.get_by_role("option", name="plate", exact=True).click()
    screen.wait_for("set.glb: 40 x 24 x 20 mm, unit as the file states")
    screen.shoot("one-solid")
    screen.press("Make the part")
    wait(lambda: "set" in [part.name for part in bench.state.cell.parts], "the part")
    assert np.ptp(bench.state.cell.part("set").mesh.points, axis=0) == pytest.approx(
        [0.04, 0.024, 0.02], abs=1e-6
    )
    assert screen.errors == []
