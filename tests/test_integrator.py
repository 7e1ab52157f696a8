"""The pages for integrators: their sources are those there are, their files are read."""

import re
import tomllib
from pathlib import Path

from workbench.devices.scanners.logins import HttpOptions
from workbench.devices.scanners.merged import MergedOptions
from workbench.extras.genicam.scanner import GenicamOptions
from workbench.extras.realsense.scanner import RealsenseOptions
from workbench.formats.cells.calibrations import read_scanned_poses
from workbench.formats.cells.reading import read_cell
from workbench.plugins.found import names
from workbench.plugins.options import options_of

DOCS = Path(__file__).resolve().parents[1] / "docs"
PAGE = "\n".join(
    (DOCS / name).read_text(encoding="utf-8")
    for name in ("integrator.md", "scanners.md", "calibration.md", "robot_links.md")
)


def example_with(key):
    """The only file on these pages with this line."""
    (found,) = (one for one in re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL) if key in one)
    return found


def test_every_source_of_a_cell_file_is_on_the_page():
    for name in names("workbench.scanners"):
        assert f"| `{name}` |" in PAGE


def test_every_row_of_what_was_run_has_its_test():
    rows = re.findall(r"^\|.*\| `(tests/[^`]+)` \|$", PAGE, re.MULTILINE)
    table = PAGE.partition("## What was run")[2].partition("\n## ")[0]
    assert len(rows) == sum(line.startswith("|") for line in table.splitlines()) - 2 > 8
    for row in rows:
        text = (Path(__file__).resolve().parents[1] / row).read_text(encoding="utf-8")
        assert re.search(r"^(async )?def test_", text, re.MULTILINE), f"{row}: no test in it"
    for name in names("workbench.robot_links"):
        assert f"`{name}`" in table


def test_a_cell_with_a_robot_of_universal_robots_is_read(tmp_path):
    controller = cell_with("ur-rtde", tmp_path)
    assert (controller.link, controller.port, controller.state_port) == ("ur-rtde", 30002, 30004)
    assert controller.options == {"gripper_output": 0, "grip_s": 0.5}


def test_a_cell_with_externally_guided_motion_is_read(tmp_path):
    controller = cell_with("abb-egm", tmp_path)
    assert (controller.link, controller.port, controller.state_port) == ("abb-egm", 6510, 6520)
    assert controller.options == {"silence_ms": 100}


def cell_with(link, tmp_path):
    wanted = example_with(f'protocol = "{link}"')
    shipped = Path(read_cell.__code__.co_filename).parents[3] / "robots" / "tx2_90"
    for file in shipped.iterdir():
        (tmp_path / file.name).symlink_to(file)
    text = (shipped / "cell.toml").read_text()
    before, _, rest = text.partition("[controller]")
    after = rest.partition("\n[")[1] + rest.partition("\n[")[2]
    (tmp_path / "cell.toml").unlink()
    (tmp_path / "cell.toml").write_text(before + wanted + after)
    return read_cell(tmp_path / "cell.toml").controller


def test_the_keys_of_a_depth_camera_are_those_of_its_driver():
    wanted = tomllib.loads(example_with('source = "genicam"'))["scanner"]
    options = options_of(GenicamOptions, wanted["options"])
    assert (options.serial, options.exposure_us) == ("21A0042", 8000.0)


def test_the_keys_of_a_page_with_a_login_are_those_of_its_driver():
    wanted = tomllib.loads(example_with('source = "http"'))["scanner"]
    options = options_of(HttpOptions, wanted["options"])
    assert (options.login, options.user, options.secret_variable) == ("digest", "cell7", "")


def test_the_keys_of_realsense_are_those_of_its_driver():
    wanted = tomllib.loads(example_with('source = "realsense"'))["scanner"]
    options = options_of(RealsenseOptions, wanted["options"])
    assert (options.columns, options.rows, options.skipped_frames) == (848, 480, 15)


def test_the_keys_of_several_scanners_are_those_of_their_driver():
    wanted = tomllib.loads(example_with('source = "merged"'))["scanner"]
    assert options_of(MergedOptions, wanted["options"]).views == "left.toml, right.toml"


def test_the_files_on_the_page_are_read(tmp_path):
    detections, calibration = example_with("[detections]"), example_with("[[pose]]")
    (tmp_path / "calibration.toml").write_text(calibration)
    (tmp_path / "pose_1.ply").write_bytes(b"ply")
    found = read_scanned_poses(tmp_path, read_cell("yumi"))
    assert (found.arm, found.unit, len(found.poses)) == ("right", "mm", 1)
    shipped = Path(read_cell.__code__.co_filename).parents[3] / "robots" / "yumi"
    (tmp_path / "yumi").symlink_to(shipped)
    text = (shipped / "cell.toml").read_text().replace('"yumi.', '"yumi/yumi.')
    text = text.replace('"meshes/', '"yumi/meshes/')
    (tmp_path / "cell.toml").write_text(f"{text}\n{detections}")
    folder = read_cell(tmp_path / "cell.toml").poses_folder
    assert (folder.path, folder.part) == (str(tmp_path / "poses"), "keyed_cylinder")
