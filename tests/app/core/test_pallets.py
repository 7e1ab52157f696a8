"""Pallets: parts stay where they are put, and the next one goes elsewhere."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from penetration import deepest, nearest

from workbench.app.core.cell.changes import EmptyPallets
from workbench.app.core.command import Entry
from workbench.app.core.cycle.sending import LinkEnded
from workbench.app.core.decide import check_allowed, decide
from workbench.app.core.people import ROBOT_LINK
from workbench.app.core.state import Phase, State
from workbench.app.picking.facts import with_facts
from workbench.app.picking.pipeline import plan_pick
from workbench.app.picking.stations import put_down
from workbench.app.runtime.work import boxes_around
from workbench.formats.cells.reading import read_cell
from workbench.formats.files.shipped import find
from workbench.model.errors import CommandRefused, FileError, InputError
from workbench.model.geometry import pose_from_rpy
from workbench.model.motion import LEG_NAMES
from workbench.model.scan import Detection
from workbench.model.symmetry import make_turn


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    """The TX2-90 with a pallet of 2 x 2 instead of its tray."""
    folder = tmp_path_factory.mktemp("pallet")
    text = (find("robots", "tx2_90") / "cell.toml").read_text()
    head, place, rest = text.partition("[[arm.place]]")
    rest = rest[rest.index("[bin]") :]
    one = "[[arm.place]]\nposition_mm = [250, -560, 190]\nrpy_deg = [180, 0, 0]\n"
    grid = "grid = [2, 2]\npitch_mm = [-110, -110]\n\n"
    head = head.replace('tool = "suction_cup"', 'tool = "suction_cup"\nkeeps_parts = true')
    text = head + one + grid + rest
    for name in ("tx2_90.urdf", "tx2_90.srdf"):
        text = text.replace(f'"{name}"', f'"{find("robots", "tx2_90") / name}"')
    (folder / "cell.toml").write_text(text)
    assert place
    return folder / "cell.toml"


@pytest.fixture(scope="module")
def cell(path):
    return read_cell(path)


def in_the_bin(cell, x=0.0, y=0.0) -> tuple[Detection, ...]:
    height = float(np.ptp(cell.parts[0].mesh.points[:, 2])) / 2
    T = cell.bin.T_world_bin * pose_from_rpy((x, y, height + 0.0005))
    return (Detection("puck", T),)


def done(state: State, fault: str = "") -> State:
    command = with_facts(state, LinkEnded(fault, 0 if fault else 1))
    check_allowed(state, command, ROBOT_LINK, 1.0)
    return decide(state, Entry(state.number + 1, 1.0, ROBOT_LINK, command))[0]


def test_a_grid_is_written_out(cell):
    (arm,) = cell.arms
    assert arm.keeps_parts and len(arm.Ts_world_place) == 4
    places = np.array([T.translation for T in arm.Ts_world_place])
    expected = [[250, -560], [140, -560], [250, -450], [140, -450]]
    np.testing.assert_allclose(places[:, :2] * 1000, expected, atol=1e-6)


def test_every_part_goes_to_a_place_of_its_own_until_the_pallet_is_full(cell):
    state = State(cell, Phase.SENDING)
    spots: list[np.ndarray] = []
    for number in range(4):
        obstacles = boxes_around(cell, state.placed)
        result = plan_pick(cell, in_the_bin(cell), f"scan {number}", obstacles=obstacles)
        assert result.plan is not None, str(result.verdict)
        assert result.proof.holds, result.proof.violations
        (one,) = result.plan.arms
        for leg, earlier in product(LEG_NAMES, state.placed):
            part = cell.part(earlier.part)
            assert nearest(cell, result.plan, one, leg, part, earlier.T_world_part) > 0.0
        # The cup leaves the part as deep in its lip as it has held it, and not through it.
        assert deepest(cell, result.plan, one, "home", one) > -cell.arms[0].tool.press - 0.001
        state = done(replace(state, phase=Phase.SENDING, plan=result.plan))
        assert len(state.placed) == number + 1
        spots.append(state.placed[-1].T_world_part.translation[:2])
    gaps = [np.linalg.norm(a - b) for k, a in enumerate(spots) for b in spots[:k]]
    assert min(gaps) > 0.1
    full = plan_pick(cell, in_the_bin(cell), "scan", obstacles=boxes_around(cell, state.placed))
    assert full.plan is None
    assert any(str(one.verdict.reason) == "no place" for one in full.candidates)


def test_after_a_fault_the_place_counts_as_taken(cell):
    result = plan_pick(cell, in_the_bin(cell), "scan")
    state = done(State(cell, Phase.SENDING, plan=result.plan), "the link broke")
    assert state.phase is Phase.FAULT and len(state.placed) == 1


def test_a_person_says_that_the_pallets_are_empty(cell):
    result = plan_pick(cell, in_the_bin(cell), "scan")
    state = done(State(cell, Phase.SENDING, plan=result.plan))
    after, effects = decide(state, Entry(9, 1.0, "ada", EmptyPallets()))
    assert after.placed == () and effects == ()
    with pytest.raises(CommandRefused, match="empty already"):
        check_allowed(after, EmptyPallets(), "ada", 1.0)


def test_a_roll_that_nobody_knows_is_not_known_on_the_pallet_either(cell):
    axis = np.array([[0.004, 0.0, 0.0], [0.0, 0.6, 0.8]])
    result = plan_pick(cell, in_the_bin(cell), "scan")
    found = [replace(one, roll_known=False, roll_axis=axis) for one in result.plan.detections]
    (kept,) = put_down(cell, replace(result.plan, detections=tuple(found)))
    assert not kept.roll_known and np.array_equal(kept.roll_axis, axis)

    (box,) = boxes_around(cell, (kept,))
    points = cell.part(kept.part).mesh.points
    T_box_part = box.T_world_box.inverse() * kept.T_world_part
    for angle in np.linspace(0.0, 2 * np.pi, 17):
        T = T_box_part * make_turn(axis[1], float(angle), axis[0])
        at = points @ T.rotation.T + T.translation
        assert np.all(np.abs(at) <= box.size / 2 + 1e-9)


def test_a_part_on_a_pallet_that_the_cell_has_lost_is_told_of(cell):
    placed = (Detection("brick", pose_from_rpy((0, 0, 0))),)
    with pytest.raises(InputError, match=r"brick lies on a pallet, .* empty the pallets"):
        boxes_around(cell, placed)


def test_an_arm_with_trays_leaves_nothing_behind():
    cell = read_cell("tx2_90")
    result = plan_pick(cell, in_the_bin(cell), "scan")
    assert done(State(cell, Phase.SENDING, plan=result.plan)).placed == ()


@pytest.mark.parametrize(
    ("new", "expected"),
    [
        ("grid = [2, 0]", "is not between"),
        ("grid = [100, 100]", "400 are allowed"),
        ("grid = [2]", "2 or 3 numbers are expected"),
    ],
)
def test_a_wrong_grid_says_which_key(path, tmp_path, new, expected):
    (tmp_path / "cell.toml").write_text(path.read_text().replace("grid = [2, 2]", new))
    with pytest.raises(FileError, match=expected):
        read_cell(tmp_path / "cell.toml")
