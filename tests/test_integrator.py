"""The page for integrators: its sources are those there are, its files are read."""

import re
from pathlib import Path

from workbench.formats.cells.calibrations import read_scanned_poses
from workbench.formats.cells.reading import read_cell
from workbench.plugins.scanner import scanner_names

PAGE = (Path(__file__).resolve().parents[1] / "docs" / "integrator.md").read_text(encoding="utf-8")


def test_every_source_of_a_cell_file_is_on_the_page():
    for name in scanner_names():
        assert f"| `{name}` |" in PAGE


def test_the_files_on_the_page_are_read(tmp_path):
    detections, calibration = re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL)
    (tmp_path / "calibration.toml").write_text(calibration)
    (tmp_path / "pose_1.ply").write_bytes(b"ply")
    found = read_scanned_poses(tmp_path, read_cell("yumi"))
    assert (found.arm, found.unit, len(found.poses)) == ("right", "mm", 1)
    assert "[detections]" in detections
    shipped = Path(read_cell.__code__.co_filename).parents[3] / "robots" / "yumi"
    (tmp_path / "yumi").symlink_to(shipped)
    text = (shipped / "cell.toml").read_text().replace('"yumi.', '"yumi/yumi.')
    text = text.replace('"meshes/', '"yumi/meshes/')
    (tmp_path / "cell.toml").write_text(f"{text}\n{detections}")
    folder = read_cell(tmp_path / "cell.toml").poses_folder
    assert (folder.path, folder.part) == (str(tmp_path / "poses"), "keyed_cylinder")
