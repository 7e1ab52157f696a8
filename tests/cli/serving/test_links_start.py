"""Every robot link has a simulated controller that starts as `demo` and `serve` start it."""

import re
import shutil
from dataclasses import replace

import pytest

from workbench.cli.serving.simulation import simulated_controller
from workbench.formats.cells.reading import cell_path, read_cell
from workbench.plugins.found import names
from workbench.plugins.robot_link import link_named, states

ROBOTS = {
    "ur": ("tx2_90", 30002, 30004),
    "abb": ("yumi", 6510, 6520),
    "pick": ("tx2_90", 6530, 6540),
}
"""For links of a maker: a cell that they can serve, and its ports."""

LIBRARIES = {"ur-rtde": "rtde_receive", "abb-egm": "google.protobuf"}

LINKS = sorted({link_named(name).motion.link for name in names("workbench.robot_links")})


def cell_file(folder, of, **controller):
    """A cell that ships, spoken to in another way."""
    shutil.copytree(cell_path(of).parent, folder)
    file = folder / "cell.toml"
    text = file.read_text(encoding="utf-8")
    for key, value in controller.items():
        text = re.sub(rf"(?m)^{key} = .*$", f"{key} = {value}", text)
    file.write_text(text, encoding="utf-8")
    return file


@pytest.mark.extensive
@pytest.mark.parametrize("name", LINKS)
def test_each_link_starts_as_demo_starts_it_and_reports_where_the_robot_stands(name, tmp_path):
    for link, library in LIBRARIES.items():
        if name.startswith(link):
            pytest.importorskip(library, reason=f"what {link} needs is not installed")
    of, port, state_port = ROBOTS.get(name.partition("-")[0], ROBOTS["abb"])
    said = {"protocol": f'"{name}"', "port": port, "state_port": state_port}
    file = cell_file(tmp_path / "cell", of, **said)
    cell = read_cell(file)
    assert cell.controller.link == name
    with simulated_controller(str(file), cell.controller) as controller:
        state = next(states(replace(cell, controller=controller)))
    assert (state.fault, state.moving) == ("", "")
    for arm in cell.arms:
        assert state.joints[arm.name] == pytest.approx(arm.home.tolist(), abs=1e-4)
