"""`views.toml`: where each scan of a part was taken from."""

import numpy as np
import pinocchio as pin
import pytest

from workbench.extras.reconstruction.part_views import read_views
from workbench.formats.clouds.scans import write_cloud
from workbench.model.errors import FileError
from workbench.model.scan import Scan

HEAD = 'format = "workbench-views/1"\nlow_mm = [-50, -50, 0]\nhigh_mm = [50, 50, 80]\n'
TABLE = "[turntable]\naxis = [0, 0, -2]\npoint_mm = [0, 0, 600]\n"


@pytest.fixture
def folder(tmp_path):
    """Three scans of one point each, 100 mm beside the turntable's axis."""
    for name in "abc":
        scan = Scan(np.array([[0.1, 0.0, 0.6]]), pin.SE3.Identity(), name)
        write_cloud(tmp_path / f"{name}.ply", scan)
    return tmp_path


def turned(*angles):
    return "".join(
        f'[[scan]]\nfile = "{name}.ply"\nangle_deg = {angle}\n'
        for name, angle in zip("abc", angles, strict=True)
    )


def test_a_turntable_turns_about_its_axis(folder):
    (folder / "views.toml").write_text(HEAD + TABLE + turned(0, 90, -90))
    views = read_views(folder)
    assert np.allclose(views.low, [-0.05, -0.05, 0]) and np.allclose(views.high, [0.05, 0.05, 0.08])
    points = [scan.points_world[0] for scan in views.scans]
    # As seen from the table the scanner goes round the other way.
    assert np.allclose(points[0], [0.1, 0, 0], atol=1e-9)
    assert np.allclose(points[1], [0, -0.1, 0], atol=1e-9)
    assert np.allclose(points[2], [0, 0.1, 0], atol=1e-9)
    assert [scan.source for scan in views.scans] == ["a.ply", "b.ply", "c.ply"]


def test_poses_are_matrices_in_millimetres(folder):
    matrix = "T_model_scanner = [0, -1, 0, 10, 1, 0, 0, 20, 0, 0, 1, 30, 0, 0, 0, 1]\n"
    rows = "".join(f'[[scan]]\nfile = "{name}.ply"\n{matrix}' for name in "abc")
    (folder / "views.toml").write_text(HEAD + rows)
    assert np.allclose(read_views(folder).scans[1].points_world[0], [0.01, 0.12, 0.63])


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (HEAD + TABLE, "3 to 200 scans are expected, 0 are given"),
        (HEAD + TABLE + turned(0, 1, 2).replace("c.ply", "d.ply"), "there is no file 'd.ply'"),
        (HEAD.replace("50, 80", "-50, 80") + TABLE + turned(0, 1, 2), "must be larger"),
        (HEAD + TABLE.replace("-2", "0") + turned(0, 1, 2), "is no direction"),
        (HEAD + turned(0, 1, 2), "T_model_scanner"),
        (HEAD + turned(0, 1, 2).replace("angle_deg = 0", f"T_model_scanner = {[2] * 16}"), "pose"),
        (HEAD + TABLE + turned(0, 1, 2) + "turn = 1\n", "turn"),
        (HEAD.replace("views/1", "views/2"), "workbench-views/1"),
    ],
)
def test_what_is_wrong_is_said(folder, text, says):
    (folder / "views.toml").write_text(text)
    with pytest.raises(FileError, match=says):
        read_views(folder)
