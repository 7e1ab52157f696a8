"""Cell files, the shipped one and spoiled ones."""

import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from mutations import mutated, only_file_errors

from workbench.formats.cells.reading import read_cell
from workbench.formats.files.shipped import find
from workbench.model.cell import LIFT_NAMES
from workbench.model.errors import FileError

SHIPPED = find("robots", "yumi")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A copy of the shipped cell to spoil."""
    return Path(shutil.copytree(SHIPPED, tmp_path / "robots" / "mine"))


def with_change(folder: Path, old: str, new: str) -> Path:
    path = folder / "cell.toml"
    text = path.read_text(encoding="utf-8")
    assert old in text, f"{old!r} is not in the cell file"
    path.write_text(text.replace(old, new, 1), encoding="utf-8")
    return path


def test_a_cell_is_found_by_name_by_folder_and_by_file(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    digest = read_cell("yumi").digest
    assert read_cell(folder).digest == read_cell(folder / "cell.toml").digest == digest
    monkeypatch.chdir(folder.parents[1])
    assert read_cell("mine").digest == digest


def test_an_unknown_name_lists_those_there_are() -> None:
    with pytest.raises(FileError, match=r"(?s)no-such-cell.*yumi"):
        read_cell("no-such-cell")


def test_millimetres_and_degrees_become_metres_and_radians() -> None:
    cell = read_cell("yumi")
    assert cell.bin.size.tolist() == [0.2, 0.3, 0.05]
    assert cell.bin.T_world_bin.translation.tolist() == [0.41, 0.0, -0.005]
    assert cell.policy.margin == 0.005
    assert cell.policy.lift_lean == pytest.approx(np.deg2rad(25))
    assert cell.arm("right").tool.stroke == (0.0, 0.05)


def test_joints_run_1_2_7_3_4_5_6_along_the_chain_and_1_to_7_on_the_wire() -> None:
    arm = read_cell("yumi").arm("right")
    assert [name[-1] for name in arm.joints] == list("1273456")
    assert [arm.joints[k][-1] for k in arm.axis_order] == list("1234567")
    on_wire = np.rad2deg(arm.home[list(arm.axis_order)])
    assert on_wire.tolist() == pytest.approx([0, -130, 30, 0, 40, 0, -135])


def test_signs_turn_axes_on_the_wire_and_at_home(folder: Path) -> None:
    with_change(
        folder, "home_deg = [0, -130,", "signs = [1, -1, 1, 1, 1, 1, 1]\nhome_deg = [0, 130,"
    )
    assert (
        read_cell(folder).arm("right").home.tolist() == read_cell("yumi").arm("right").home.tolist()
    )
    assert read_cell(folder).arm("right").axis_signs == (1, -1, 1, 1, 1, 1, 1)


def test_the_former_name_of_a_key_is_read_as_well_and_changes_no_digest(folder: Path) -> None:
    digest = read_cell(folder).digest
    for name in "RL":
        with_change(folder, f'controller_id = "{name}"', f'letter = "{name}"')
    assert [arm.controller_id for arm in read_cell(folder).arms] == ["R", "L"]
    assert read_cell(folder).digest == digest


def test_the_digest_covers_all_but_the_address(folder: Path) -> None:
    digest = read_cell(folder).digest
    with_change(folder, "port = 1025", "port = 2025")
    assert read_cell(folder).digest == digest
    with_change(folder, "margin_mm = 5 ", "margin_mm = 6 ")
    assert read_cell(folder).digest != digest


def test_a_bin_without_walls_has_another_digest_and_one_that_says_it_has_them_the_same(
    folder: Path,
) -> None:
    cell = read_cell(folder)
    with_change(folder, "wall_mm = 3", "wall_mm = 3\nwalls = true")
    assert read_cell(folder).digest == cell.digest
    with_change(folder, "walls = true", "walls = false")
    table = read_cell(folder)
    assert table.digest != cell.digest
    assert [one.name for one in table.bin.solids] == ["bin_floor"]
    with_change(folder, "walls = false", "walls = 0")
    with pytest.raises(FileError, match=r"bin\.walls"):
        read_cell(folder)


def test_links_can_go_without_their_geometry(folder: Path) -> None:
    with_change(folder, 'srdf = "yumi.srdf"', 'srdf = "yumi.srdf"\nwithout_geometry = ["body"]')
    robot = read_cell(folder).robot
    assert robot.link("body").collision == ()
    assert robot.link("body").visual == ()
    assert robot.link("right_link_1").collision


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ('name = "yumi"', 'name = "yumi"\ncolour = "red"', ["colour"]),
        ("margin_mm = 5 ", "margin = 5 ", ["policy", "margin", "margin_mm"]),
        ("margin_mm = 5 ", "margin_mm = -1 ", ["margin_mm", "-1"]),
        ("margin_mm = 5 ", 'margin_mm = "5" ', ["margin_mm", "number"]),
        ("margin_mm = 5 ", "margin_mm = nan ", ["margin_mm"]),
        ('urdf = "yumi.urdf"', 'urdf = "gone.urdf"', ["gone.urdf"]),
        ('parts = ["keyed_cylinder"]', 'parts = ["nut"]', ["nut", "keyed_cylinder"]),
        ('parts = ["keyed_cylinder"]', "parts = []", ["parts"]),
        ('tool = "smart_gripper"', 'tool = "hook"', ["hook", "smart_gripper"]),
        ('flange = "right_flange"', 'flange = "nose"', ["flange", "nose"]),
        ('flange = "right_flange"', 'flange = "body"', ["flange", "body"]),
        ('name = "left"', 'name = "right"', ["arm"]),
        ("axes = [1, 2, 7, 3, 4, 5, 6]", "axes = [1, 2, 7, 3, 4, 5, 5]", ["axes", "1 to 7"]),
        ("axes = [1, 2, 7, 3, 4, 5, 6]", "axes = [1, 2, 3]", ["axes", "7"]),
        ("home_deg = [0, -130,", "home_deg = [0, 130,", ["home_deg", "130.0", "outside"]),
        ("stroke_mm = [0, 50]", "stroke_mm = [50, 0]", ["stroke_mm"]),
        ("size_mm = [200, 300, 50]", "size_mm = [200, 300]", ["size_mm", "3"]),
        ("size_mm = [200, 300, 50]", "size_mm = [0.2, 0.3, 0.05]", ["size_mm"]),
        ("near_mm = 500", "near_mm = 5000", ["near_mm", "far_mm"]),
        ("port = 1025", "port = 70000", ["port", "70000"]),
        ('protocol = "abb-socket/2"', 'protocol = "telnet"', ["telnet", "abb-socket"]),
        ("opens_along = [1, 0, 0]", "opens_along = [1, 1, 0]", ["opens_along", "unit"]),
        ('shape = "box"', 'shape = "cone"', ["cone"]),
        ('planner = "rrtconnect"', 'planner = "magic"', ["planner", "magic", "sbl"]),
        ('controller_id = "R"', 'controller_id = "#"', ["controller_id", "#"]),
        ('controller_id = "R"', 'letter = "r"', ["letter", "capital"]),
        (
            'controller_id = "R"',
            'controller_id = "L"',
            ["arm.controller_id", "'L' is there 2 times"],
        ),
        (
            'controller_id = "R"',
            'controller_id = "R"\nletter = "R"',
            ["letter", "is called controller_id now"],
        ),
        (
            'parts = ["keyed_cylinder"]',
            'parts = ["keyed_cylinder", "keyed_cylinder"]',
            ["parts", "'keyed_cylinder' is there 2 times"],
        ),
        ('parts = ["keyed_cylinder"]', f'parts = ["{"a" * 300}"]', ["parts", "aaa"]),
        (
            "[[arm]]",
            '[[tool]]\nname = "smart_gripper"\n[tool.tcp]\n[[tool.body]]\nname = "ball"\n'
            'shape = "sphere"\nradius_mm = 10\n\n[[arm]]',
            ["tool.name", "'smart_gripper' is there 2 times"],
        ),
        (
            "[[arm]]",
            '[[fixture]]\nname = "a"\n\n[[fixture]]\nname = "a"\n\n[[arm]]',
            ["fixture.name", "'a' is there 2 times"],
        ),
        ("[controller]", "[controler]", ["controler"]),
    ],
)
def test_what_is_wrong_is_named(folder: Path, old: str, new: str, expected: list[str]) -> None:
    path = with_change(folder, old, new)
    with pytest.raises(FileError) as caught:
        read_cell(path)
    message = str(caught.value)
    assert str(folder) in message
    assert message.isprintable()
    for word in expected:
        assert word in message


def test_a_pair_of_links_that_are_not_there_is_refused(folder: Path) -> None:
    srdf = folder / "yumi.srdf"
    srdf.write_text(srdf.read_text(encoding="utf-8").replace('"body"', '"belly"', 1))
    with pytest.raises(FileError, match=r"yumi\.srdf: names link 'belly'"):
        read_cell(folder)


@given(content=mutated((SHIPPED / "cell.toml").read_bytes()))
@settings(
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
    max_examples=40,
    deadline=None,
)
def test_no_file_is_worse_than_an_error(tmp_path: Path, content: bytes) -> None:
    only_file_errors(tmp_path / "cell.toml", content, read_cell)


def with_policy(folder: Path, lines: str) -> Path:
    """The shipped cell with lines of its own for lifts and air."""
    path = folder / "cell.toml"
    rows = path.read_text(encoding="utf-8").splitlines()
    kept = [row for row in rows if not row.startswith(("lifts =", "least_air_mm ="))]
    text = "\n".join(kept).replace("[policy]", f"[policy]\n{lines}", 1)
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("line", "problem"),
    [
        ('lifts = ["sideways"]', "is none of leaning, up, back, off-wall, around, any"),
        ("lifts = []", "each once"),
        ('lifts = ["up", "up"]', "each once"),
        ("least_air_mm = -1", "least_air_mm"),
    ],
)
def test_lifts_and_the_least_air_are_checked(folder: Path, line: str, problem: str) -> None:
    with pytest.raises(FileError, match=problem):
        read_cell(with_policy(folder, line))


def test_lifts_and_the_least_air_are_read(folder: Path) -> None:
    cell = read_cell(with_policy(folder, 'lifts = ["up", "around"]\nleast_air_mm = 1.5'))
    assert cell.policy.lifts == ("up", "around")
    assert cell.policy.least_air == pytest.approx(0.0015)


def test_a_cell_says_how_it_empties_bins_by_one_word_and_its_own_keys_come_first(
    folder: Path,
) -> None:
    digest = read_cell(folder).digest
    assert read_cell(with_policy(folder, 'emptying = "as-needed"')).digest == digest
    quick = read_cell(with_change(folder, '"as-needed"', '"quick"'))
    assert not quick.policy.as_needed and quick.digest != digest
    with_change(folder, 'emptying = "quick"\n', "")
    policy = read_cell(with_policy(folder, 'emptying = "thorough"')).policy
    assert (policy.lifts, policy.least_air, policy.pair_gap) == (LIFT_NAMES, 0.0015, 0.01)
    own = with_change(folder, '"thorough"', '"thorough"\nlifts = ["up"]')
    assert (read_cell(own).policy.lifts, read_cell(own).policy.least_air) == (("up",), 0.0015)
    with pytest.raises(FileError, match="quick"):
        read_cell(with_change(folder, '"thorough"', '"slow"'))


def test_who_names_some_lifts_wants_no_others(folder: Path) -> None:
    assert not read_cell(with_policy(folder, 'lifts = ["up"]')).policy.as_needed
    every = ", ".join(f'"{name}"' for name in LIFT_NAMES)
    assert read_cell(with_change(folder, '["up"]', f"[{every}]")).policy.as_needed


def test_a_cell_that_names_no_other_lift_has_the_digest_of_before(folder: Path) -> None:
    silent = read_cell(with_policy(folder, ""))
    assert read_cell(with_policy(folder, 'lifts = ["leaning"]')).digest == silent.digest
    assert read_cell(with_policy(folder, 'lifts = ["up"]')).digest != silent.digest


def test_picks_a_scan_need_a_gap_and_change_no_digest_where_one_is_wanted(folder: Path) -> None:
    digest = read_cell(folder).digest
    path = with_change(folder, "[policy]", "[policy]\npicks = 1")
    assert (read_cell(path).policy.picks, read_cell(path).digest) == (1, digest)
    with_change(folder, "picks = 1", "picks = 3")
    with pytest.raises(FileError, match=r"(?s)cell\.toml.*picks.*need a pair_gap_mm"):
        read_cell(path)
    with_change(folder, "picks = 3", "picks = 3\npair_gap_mm = 10")
    assert read_cell(path).policy.picks == 3
    with_change(folder, "picks = 3", "picks = 11")
    with pytest.raises(FileError, match=r"picks.*11 is not a whole number from 1 to 10"):
        read_cell(path)


def test_limits_of_speed_are_read_and_change_no_digest_where_there_are_none(folder: Path) -> None:
    digest = read_cell(folder).digest
    keys = "tcp_speed_mm = 400\npoint_speed_mm = 500\nheld_speed_mm = 250\nmanual_speed = true"
    limited = read_cell(with_change(folder, "[policy]", f"[policy]\n{keys}"))
    policy = limited.policy
    speeds = policy.tcp_speed, policy.point_speed, policy.held_speed, policy.manual_speed
    assert speeds == (0.4, 0.5, 0.25, True) and limited.digest != digest
    same = read_cell(with_change(folder, keys, "manual_speed = false"))
    assert same.digest == digest


@pytest.mark.parametrize(
    ("keys", "problem"),
    [
        ("tcp_speed_mm = 0", "policy.tcp_speed_mm: 0 is not between 1 and 50000"),
        ("point_speed_mm = -5", "policy.point_speed_mm: -5 is not between 1 and 50000"),
        ("held_speed_mm = nan", "policy.held_speed_mm"),
        ('manual_speed = "yes"', "policy.manual_speed"),
        (
            "point_speed_mm = 200\nheld_speed_mm = 300",
            "policy.held_speed_mm: is above point_speed_mm: a part makes it slower",
        ),
    ],
)
def test_limits_of_speed_that_cannot_be_are_refused(folder: Path, keys: str, problem: str) -> None:
    with pytest.raises(FileError, match=f"(?s){problem}"):
        read_cell(with_change(folder, "[policy]", f"[policy]\n{keys}"))


def test_a_rule_to_stir_needs_times_and_walls(folder):
    path = with_change(folder, "[policy]", "[policy]\nstirs = 3\nstir_speed_mm = 80")
    policy = read_cell(path).policy
    assert (policy.stirs, policy.stir_speed) == (3, 0.08)
    with_change(folder, 'protocol = "abb-socket/2"', 'protocol = "abb-socket"')
    with pytest.raises(FileError, match=r"policy\.stirs: .* does not send times"):
        read_cell(path)


def test_energy_is_limited_where_arm_and_tool_state_their_masses(folder: Path) -> None:
    path = with_change(folder, "[policy]", "[policy]\ncontact_energy_j = 0.5")
    with pytest.raises(FileError, match=r"contact_energy_j: arm right has no moving_mass_kg"):
        read_cell(path)
    text = path.read_text().replace('flange = "', 'moving_mass_kg = 9.5\nflange = "')
    path.write_text(text)
    cell = read_cell(path)
    assert [arm.moving_mass for arm in cell.arms] == [9.5, 9.5]
    assert cell.policy.contact_energy == 0.5
    path.write_text(re.sub(r"(mass_g|centre_of_gravity_mm|inertia_kgm2) = .*", "", text))
    with pytest.raises(FileError, match=r"contact_energy_j: arm right has no mass_g of "):
        read_cell(path)


def test_a_link_without_times_and_an_arm_with_jerk_limit_no_speed(folder: Path) -> None:
    path = with_change(folder, "[policy]", "[policy]\nmanual_speed = true")
    with_change(folder, '"abb-socket/2"', '"abb-socket"')
    with pytest.raises(FileError, match=r"manual_speed: robot link abb-socket does not send"):
        read_cell(path)
    with_change(folder, '"abb-socket"', '"abb-socket/2"')
    with_change(folder, "acceleration_deg = 600", "acceleration_deg = 600\njerk_deg = 9000")
    with pytest.raises(FileError, match=r"policy\.manual_speed: arm right has jerk_deg"):
        read_cell(path)
