"""A scan from a file in a real browser: parts found, one vetoed, one corrected by gizmo."""

import re
from dataclasses import replace

import numpy as np
import pytest
from hands import drag, first_look, pause, settle
from playwright.sync_api import expect

from workbench.app.core.cell.changes import UndoCell
from workbench.formats.cells.reading import read_cell
from workbench.formats.clouds.scans import read_scan, write_cloud
from workbench.gui.parts.panel import GIZMO
from workbench.perception.simulation.piles import drop_parts
from workbench.perception.simulation.synthesize import synthesize


@pytest.fixture(scope="module")
def scan_file(tmp_path_factory):
    cell = read_cell("yumi")
    scan = synthesize(cell, drop_parts(cell.parts[:1] * 3, cell.bin, seed=2), seed=2)
    path = tmp_path_factory.mktemp("scan") / "from_elsewhere.ply"
    write_cloud(path, scan)
    return path


def test_an_uploaded_scan_gives_parts_to_veto_and_correct(screen, bench, wait, reaches, scan_file):
    screen.tab("Parts")
    with screen.page.expect_file_chooser() as chooser:
        screen.press("Scan from file")
    chooser.value.set_files(scan_file)
    state = reaches("scanned")
    assert state.scan.source == "from_elsewhere.ply"
    screen.tab("Cycle")
    screen.press("Find parts")
    found = reaches("localized").detections
    assert len(found) == 3
    screen.tab("Parts")
    rows = screen.page.locator(".wb-parts tbody tr")
    rows.nth(2).wait_for()
    expect(rows).to_have_count(3)
    screen.shoot("parts")
    screen.page.locator(".wb-rejected summary").click()
    screen.page.locator(".wb-rejected li").first.wait_for()
    box = screen.page.locator("input[type=checkbox]:visible").first
    box.click()
    screen.page.wait_for_timeout(1500)
    screen.shoot("parts-rejected")
    assert box.is_checked()
    box.click()
    screen.page.locator(".wb-rejected summary").click()

    camera = first_look(screen.page, bench.state.cell)
    highest = int(np.argmax([one.T_world_part.translation[2] for one in found]))
    middle = bench.state.cell.part(found[highest].part).mesh.middle
    screen.page.mouse.click(*camera.pixel(found[highest].T_world_part.act(middle)))
    expect(rows.nth(highest)).to_have_attribute("style", re.compile("wb-chosen"))

    rows.nth(2).click()
    pause(screen.page, 300)
    screen.press("Veto")
    wait(lambda: len(bench.state.detections or ()) == 2, "the veto")
    assert "part-3 (keyed_cylinder) was vetoed" in str(bench.state.message)
    for one, other in zip(bench.state.detections, found[:2], strict=True):
        assert one.T_world_part == other.T_world_part and one.score == other.score

    rows.nth(0).click()
    pause(screen.page, 300)
    screen.press("Show gizmo")
    # The camera has gone to the row: back to where the mouse is worked out from.
    screen.page.get_by_text("Default view", exact=True).click()
    settle(screen.page, 1000)
    T = bench.state.detections[0].T_world_part
    camera = first_look(screen.page, bench.state.cell)
    axes = T.rotation.T @ camera.axes[2]
    axis = int(np.argmin(np.abs(axes)))  # the one that is seen best from the side
    tip = T.translation + 0.9 * GIZMO * T.rotation[:, axis]
    drag(screen.page, camera.pixel(tip), camera.pixel(tip + 0.02 * T.rotation[:, axis]))
    wait(lambda: "corrected by hand" in str(bench.state.message), "the correction")
    U = bench.state.detections[0].T_world_part
    moved = T.actInv(U).translation
    assert 0.014 < moved[axis] < 0.026, moved
    assert np.abs(np.delete(moved, axis)).max() < 0.001
    assert bench.state.phase == "localized" and bench.state.scan is not None
    screen.page.get_by_text("by hand").first.wait_for()
    screen.shoot("parts-corrected")
    assert screen.errors == []


@pytest.mark.extensive
def test_a_first_scan_in_another_unit_and_other_axes_fits_the_scanner(
    screen, bench, wait, scan_file, tmp_path
):
    cell, file = bench.state.cell, tmp_path / "first.ply"
    write_cloud(file, read_scan(scan_file, cell.scanner), unit="mm", axes="z_back")
    screen.tab("Parts")
    with screen.page.expect_file_chooser() as chooser:
        screen.press("Scan from file")
    chooser.value.set_files(file)
    screen.wait_for("workbench scanner fit")
    assert bench.state.scan is None
    with screen.page.expect_file_chooser() as chooser:
        screen.press("Fit scanner to file")
    chooser.value.set_files(file)
    wait(lambda: bench.state.scan is not None, "no scan was taken")
    scanner = bench.state.cell.scanner
    assert (scanner.unit, scanner.cloud_axes) == ("mm", "z_back")
    off = scanner.T_world_scanner.translation - cell.scanner.T_world_scanner.translation
    assert np.linalg.norm(off) < 0.005
    screen.shoot("parts-fitted")
    bench.do(UndoCell(), "Ada")
    assert bench.state.cell.digest == cell.digest


@pytest.mark.extensive
def test_a_first_scan_of_another_bin_takes_its_size(screen, bench, wait, tmp_path):
    cell, file = bench.state.cell, tmp_path / "larger.ply"
    larger = replace(cell, bin=replace(cell.bin, size=np.array([0.24, 0.34, 0.08])))
    write_cloud(
        file, synthesize(larger, drop_parts(cell.parts[:1] * 3, larger.bin, seed=2), seed=2)
    )
    screen.tab("Parts")
    with screen.page.expect_file_chooser() as chooser:
        screen.press("Fit scanner to file")
    chooser.value.set_files(file)
    wait(lambda: bench.state.scan is not None, "no scan was taken")
    np.testing.assert_allclose(bench.state.cell.bin.size, larger.bin.size, atol=0.005)
    bench.do(UndoCell(), "Ada")
    assert bench.state.cell.digest == cell.digest


def test_a_file_that_is_no_scan_is_refused_in_words(screen, bench, tmp_path):
    (tmp_path / "picture.ply").write_bytes(b"no cloud at all")
    screen.tab("Parts")
    with screen.page.expect_file_chooser() as chooser:
        screen.press("Scan from file")
    chooser.value.set_files(tmp_path / "picture.ply")
    screen.wait_for("is neither a PLY nor a PCD file")
    assert bench.state.phase == "idle"


@pytest.mark.extensive
def test_why_a_part_is_left_is_read_after_one_press_and_no_row_moves(screen, reaches, wait):
    for step, phase in (("Scan", "scanned"), ("Find parts", "localized"), ("Plan", "planned")):
        screen.press(step)
        reaches(phase)
    page, height = screen.page, screen.page.viewport_size["height"]
    screen.tab("Parts")
    fate = page.locator(".wb-fate:visible").last
    fate.wait_for()
    box = fate.bounding_box()
    assert box["y"] > 0 and box["y"] + box["height"] < height

    screen.tab("Candidates")
    refused = page.locator(".wb-table:visible tbody .wb-refused").first
    refused.scroll_into_view_if_needed()
    before = refused.bounding_box()
    refused.click()
    reason = page.get_by_text("Where it failed").locator("visible=true").first
    reason.wait_for()
    assert refused.bounding_box()["y"] == before["y"]
    read = reason.bounding_box()
    assert read["y"] + read["height"] < height
    assert screen.errors == []
