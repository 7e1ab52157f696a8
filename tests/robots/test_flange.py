"""The flange of the YuMi is tool0 of its controller, the frame in which that reads loads."""

import numpy as np
import pinocchio as pin
import pytest

from workbench.formats.cells.reading import read_cell
from workbench.planning.kinematics.robot import Kinematics

TOOL0 = {
    "left": ((-9.58, 182.61, 198.63), (0.06601, 0.84242, -0.11121, 0.52307)),
    "right": ((-9.58, -182.61, 198.63), (0.06601, -0.84242, -0.11121, -0.52307)),
}
"""Where RobotWare says that tool0 is [mm, quaternion] with the axes at 0, -130, 30, 0, 40, 0 and
135 or -135 degrees."""


@pytest.mark.parametrize("cell", ["cell", "full_bin", "nests", "regrasp"])
def test_the_flange_stands_and_is_turned_as_the_controller_says(cell):
    found = read_cell(f"robots/yumi/{cell}.toml")
    kinematics = Kinematics(found)
    for arm in found.arms:
        assert np.rad2deg(arm.to_axes(arm.home)[:3]).round(6).tolist() == [0, -130, 30]
        T = kinematics.tcp_pose(arm, arm.home) * arm.tool.T_flange_tcp.inverse()
        place, (w, x, y, z) = TOOL0[arm.name]
        meant = pin.Quaternion(w, x, y, z).normalized().matrix()
        turned = np.linalg.norm(pin.log3(T.rotation.T @ meant))
        assert np.linalg.norm(T.translation * 1000 - place) < 2.0
        assert turned < np.deg2rad(0.3)
