"""The cell changed by hand in a real browser: jogging, gizmos, undo, save."""

import math
from functools import partial

import numpy as np
import pinocchio as pin
import pytest
from cad_tools import PALM, stl
from hands import drag, field, first_look, pause, settle, typed, unfold
from playwright.sync_api import expect

from workbench.app.runtime.bench import Bench
from workbench.app.runtime.effect_runner import EffectRunner
from workbench.formats.cells.reading import read_cell
from workbench.gui.cell.jogging import GIZMO as TOOL_GIZMO
from workbench.gui.cell.panel import GIZMO
from workbench.journal.journal import Journal
from workbench.model.geometry import pose_from_rpy
from workbench.planning.kinematics.chain import chain_of, is_solution


@pytest.fixture
def bench(tmp_path, cell_file):
    machines = partial(EffectRunner, cell_file=cell_file)
    bench = Bench(read_cell(cell_file), Journal(tmp_path / "session"), effects=machines)
    yield bench
    bench.close()


def type_number(screen, label: str, value: float) -> None:
    """Into the field beside the slider of that label."""
    box = field(screen, label)
    box.fill(f"{value:.1f}")
    box.press("Enter")
    pause(screen.page, 120)


def in_the_wall(cell) -> np.ndarray:
    """A configuration of the right arm with the tool in the bin's front wall."""
    arm, chain = cell.arms[0], chain_of(cell, cell.arms[0])
    length, _, height = cell.bin.size
    rng = np.random.default_rng(0)
    starts = np.vstack([arm.home, rng.uniform(chain.lower, chain.upper, (60, len(arm.home)))])
    for turn in (0.0, math.pi / 2, -math.pi / 2):
        p_bin = (-(length + cell.bin.wall) / 2, -0.05, height - 0.02)
        T = cell.bin.T_world_bin * pose_from_rpy(p_bin, (math.pi, 0, turn))
        answers, residuals = chain.solve(T, starts)
        found = answers[is_solution(residuals)]
        if len(found):
            return found[0]
    raise AssertionError("the arm does not reach the wall")


def test_an_arm_jogged_into_the_bin_wall_names_the_pair(screen, bench, wait):
    cell = bench.state.cell
    arm, q = cell.arms[0], in_the_wall(bench.state.cell)
    screen.tab("Cell")
    screen.press("Jog")
    screen.wait_for("Clear; nearest:")
    for axis, (k, sign) in enumerate(zip(arm.axis_order, arm.axis_signs, strict=True)):
        type_number(screen, f"Axis {axis + 1} [deg]", sign * math.degrees(q[k]))
    row = screen.page.locator(".wb-contacts tr", has_text="bin_wall_back").first
    row.wait_for()
    assert "right " in row.inner_text() and "inside" in row.inner_text()
    screen.shoot("cell-jogged")
    screen.press("Go home")
    screen.wait_for("Clear; nearest:")
    screen.press("End jogging")
    assert bench.state.before == (), "jogging changes nothing of the cell"
    assert screen.errors == []


def test_the_tool_follows_its_gizmo_and_is_taught(screen, bench, wait):
    cell = bench.state.cell
    T = chain_of(cell, cell.arms[0]).pose(np.asarray(cell.arms[0].home))
    screen.tab("Cell")
    screen.press("Jog")
    screen.wait_for("Clear; nearest:")
    settle(screen.page, 1000)
    camera = first_look(screen.page, cell)
    tip = T.translation + 0.9 * TOOL_GIZMO * T.rotation[:, 2]
    away = tip - 0.06 * T.rotation[:, 2]
    drag(screen.page, camera.pixel(tip), camera.pixel(away))
    screen.press("Teach as home")
    wait(lambda: bench.state.before != (), "another home")
    changed = bench.state.cell
    U = chain_of(changed, changed.arms[0]).pose(np.asarray(changed.arms[0].home))
    moved = T.actInv(U).translation
    assert -0.075 < moved[2] < -0.045, moved
    assert np.abs(moved[:2]).max() < 0.002
    assert np.abs(pin.log3(T.rotation.T @ U.rotation)).max() < 0.01
    screen.press("Undo")
    wait(lambda: bench.state.before == (), "the home before")
    assert bench.state.cell.digest == cell.digest


def test_a_bin_moved_by_its_gizmo_is_undone_redone_and_saved(
    screen, bench, wait, reaches, cell_file
):
    screen.press("Scan")
    reaches("scanned")
    screen.press("Find parts")
    reaches("localized")
    cell = bench.state.cell
    screen.tab("Cell")
    screen.press("Show gizmo")
    settle(screen.page, 1000)
    camera = first_look(screen.page, cell)
    p = cell.bin.T_world_bin.translation
    tip = p + [0, 0, 0.9 * GIZMO]
    drag(screen.page, camera.pixel(tip), camera.pixel(tip + [0, 0, 0.05]))
    wait(lambda: bench.state.before != (), "the bin moved")
    moved = bench.state.cell.bin.T_world_bin.translation - p
    assert 0.035 < moved[2] < 0.065 and np.abs(moved[:2]).max() < 1e-4, moved
    assert bench.state.phase == "scanned", "what was found was found in another cell"
    screen.wait_for("Changed and not saved")
    screen.shoot("cell-moved")
    there = bench.state.cell.digest
    screen.press("Undo")
    wait(lambda: bench.state.cell.digest == cell.digest, "undo")
    screen.press("Redo")
    wait(lambda: bench.state.cell.digest == there, "redo")
    field(screen, "Remark").press_sequentially("higher", delay=60)
    pause(screen.page, 200)
    screen.press("Save")
    wait(lambda: bench.state.saved == bench.state.cell.digest, "the file written")
    screen.wait_for("As in its file")
    again = read_cell(cell_file)
    assert again.digest == bench.state.cell.digest
    np.testing.assert_allclose(again.bin.T_world_bin.translation - p, moved, atol=1e-5)
    assert "higher" in (cell_file.parent / "changes.log").read_text()
    assert screen.errors == []


def test_two_clicks_measure_a_distance(screen, bench):
    cell = bench.state.cell
    screen.tab("Cell")
    screen.press("Measure")
    screen.button("Click on two points").wait_for()
    settle(screen.page, 1000)
    camera = first_look(screen.page, cell)
    centre = cell.bin.T_world_bin.translation
    for p in (centre, centre + [0.0, 0.08, 0.0]):
        screen.page.mouse.move(*camera.pixel(p))
        settle(screen.page, 200)
        screen.page.mouse.down()
        settle(screen.page, 60)
        screen.page.mouse.up()
        settle(screen.page, 700)
    screen.button("Measure").wait_for()
    said = screen.page.get_by_text(" mm: x ").inner_text()
    distance = float(said.split(" mm")[0])
    assert abs(distance - 80.0) < 2.0, said
    assert screen.errors == []


def test_a_tool_from_cad_is_told_before_it_is_taken_and_carried(screen, bench, wait, tmp_path):
    before = bench.state.cell.digest
    file = tmp_path / "palm.stl"
    file.write_bytes(stl(PALM).tobytes())
    screen.tab("Cell")
    unfold(screen, "A tool from CAD")
    with screen.page.expect_file_chooser() as chosen:
        screen.press("Choose the body")
    chosen.value.set_files(file)
    screen.wait_for("80 x 50 x 71.3 mm, assumed unit mm; z from 0 to 71.3 mm; closed")
    assert field(screen, "Fingers from z [mm]").input_value() == "71.3"
    assert bench.state.cell.digest == before, "told, and not taken"
    typed(screen, "Stroke [mm]", 40)
    screen.shoot("cell-tool-chosen")
    screen.press("Add the tool")
    wait(lambda: bench.state.before != (), "the tool")
    arm = bench.state.cell.arms[0]
    assert arm.tool.name == "palm" and arm.tool.stroke == (0.0, 0.04)
    expect(field(screen, "Object")).to_have_value("TCP palm")
    expect(field(screen, f"Tool, {arm.name}")).to_have_value("palm")
    screen.press("Show gizmo")
    settle(screen.page, 500)
    screen.shoot("cell-tool-carried")
    screen.press("Undo")
    wait(lambda: bench.state.cell.digest == before, "undo")
    assert screen.errors == []


class TestRegion:
    """A region of interest in the bin, in a window of its own."""

    @pytest.fixture
    def cell_file(self, cell_file):
        text = cell_file.read_text()
        region = (
            '[[bin.region]]\nname = "middle"\nposition_mm = [0, 0, 40]\nsize_mm = [80, 60, 60]\n'
        )
        at = text.index("\n[scanner]")
        cell_file.write_text(f"{text[:at]}\n{region}{text[at:]}")
        return cell_file

    def test_it_is_dragged_by_its_gizmo_along_with_nothing_else(self, screen, bench, wait):
        cell = bench.state.cell
        screen.tab("Cell")
        field(screen, "Object").click()
        screen.page.get_by_role("option", name="region middle").click()
        screen.press("Show gizmo")
        settle(screen.page, 1000)
        camera = first_look(screen.page, cell)
        p = (cell.bin.T_world_bin * cell.bin.regions[0].T_bin_region).translation
        tip = p + [0, 0, 0.9 * GIZMO]
        drag(screen.page, camera.pixel(tip), camera.pixel(tip + [0, 0, 0.03]))
        wait(lambda: bench.state.before != (), "the region moved")
        screen.shoot("cell-region")
        moved = bench.state.cell.bin
        T = moved.regions[0].T_bin_region
        off = T.translation - cell.bin.regions[0].T_bin_region.translation
        assert 0.015 < off[2] < 0.045 and np.abs(off[:2]).max() < 1e-4, off
        assert moved.T_world_bin.isApprox(cell.bin.T_world_bin)
        screen.press("Undo")
        wait(lambda: bench.state.cell.digest == cell.digest, "undo")
        assert screen.errors == []
