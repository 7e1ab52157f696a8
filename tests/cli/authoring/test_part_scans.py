"""`workbench part from-scans` as it is typed: scans in files, and what is wrong with them."""

import json
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
import trimesh

from workbench.formats.cells.reading import read_cell
from workbench.formats.clouds.scans import write_cloud
from workbench.formats.parts.reading import read_part
from workbench.model.geometry import pose_from_rpy
from workbench.model.part import Bin
from workbench.model.scan import Detection, Scan
from workbench.perception.simulation.synthesize import synthesize

VIEWS, RESOLUTION = 8, (320, 240)
REGION = "low_mm = [-10, -30, 0]\nhigh_mm = [85, 30, 55]\n"
HEAD = f'format = "workbench-views/1"\n{REGION}'
COARSE = ("--voxel-mm", 1.5, "--tolerance-mm", 0.5)


def turned(number: int) -> pin.SE3:
    """`T_model_scanner` after so many eighths of a turn of the table, 0.6 m away, 45 degrees up."""
    middle = pose_from_rpy((0.035, 0.0, 0.02), (0.0, 0.0, 2 * np.pi * number / VIEWS))
    return middle * pose_from_rpy((0.42, 0.0, 0.42), (-3 * np.pi / 4, 0.0, np.pi / 2))


def written(poses: list[pin.SE3], names: list[str]) -> str:
    """A `views.toml`."""
    rows = []
    for name, T in zip(names, poses, strict=True):
        matrix = T.homogeneous.copy()
        matrix[:3, 3] *= 1000
        rows.append(f'[[scan]]\nfile = "{name}"\nT_model_scanner = {matrix.ravel().tolist()}\n')
    return HEAD + "".join(rows)


NAMES = [f"scan_{k}.ply" for k in range(VIEWS)]
POSES = [turned(k) for k in range(VIEWS)]


@pytest.fixture(scope="module")
def taken(tmp_path_factory) -> Path:
    """Scans of a bracket on a turntable, and where they were taken from."""
    folder = tmp_path_factory.mktemp("taken")
    cell, part = read_cell("yumi"), read_part("bracket")
    plate = Bin(pin.SE3.Identity(), np.array([0.4, 0.4, 0.1]), has_walls=False)
    there = [Detection(part.name, pin.SE3.Identity(), 1.0)]
    for number, T in enumerate(POSES):
        mount = replace(cell.scanner, T_world_scanner=T, near=0.3, far=1.0, resolution=RESOLUTION)
        seen = replace(cell, parts=(part,), bin=plate, fixtures=(), scanner=mount)
        write_cloud(folder / NAMES[number], synthesize(seen, there, seed=number))
    (folder / "views.toml").write_text(written(POSES, NAMES))
    return folder


@pytest.fixture
def folder(taken, tmp_path) -> Path:
    """A copy that a test may spoil."""
    return Path(shutil.copytree(taken, tmp_path / "views"))


@pytest.fixture
def merge(say, tmp_path) -> Callable:
    """Merge a folder's scans coarsely, into `model.ply`."""
    return lambda folder, *words: say(
        "part", "from-scans", folder, "--out", tmp_path / "model.ply", *COARSE, *words
    )


def test_scans_become_a_model_that_becomes_a_part(say, merge, taken, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    said = merge(taken, "--json")
    assert said.code == 0, said.err
    told = json.loads(said.out)
    # The bracket is 75 x 40 x 45 mm, of 24.4 cm3; a voxel more is added at most.
    assert told["size_mm"] == pytest.approx([75, 40, 45], abs=2)
    assert told["shared"] > 0.9 and 0 < told["unseen"] < 0.4
    assert told["apart_mm"]["used"] <= told["apart_mm"]["given"] < 0.5
    model = trimesh.load_mesh(tmp_path / "model.ply")
    assert model.is_watertight and model.extents == pytest.approx(told["size_mm"], abs=0.01)
    said = say("part", "import", "model.ply", "--unit", "mm", "--name", "taught")
    assert said.code == 0, said.err
    assert np.ptp(read_part("taught").mesh.points, axis=0) == pytest.approx(
        np.array(told["size_mm"]) / 1000, abs=1e-5
    )
    again = say("part", "import", "model.ply", "--unit", "mm", "--name", "taught")
    assert again.code == 2 and "taught: is there already" in again.problem


def test_what_is_printed_says_how_far_it_can_be_believed(merge, taken, tmp_path):
    said = merge(taken, "--as-given")
    assert said.code == 0, said.err
    for words in ("8 scans, voxels of 1.50 mm", "mm apart in the median", "in common", "no scan"):
        assert words in said.out
    assert f"workbench part import {tmp_path / 'model.ply'} --unit mm" in said.out


def moved(number: int, x: float) -> list[pin.SE3]:
    """The poses, one of them wrong by so much [m]."""
    poses = list(POSES)
    poses[number] = pose_from_rpy((x, 0, 0)) * poses[number]
    return poses


@pytest.mark.parametrize(
    ("views", "says"),
    [
        (HEAD, "views.toml: key scan: 3 to 200 scans are expected, 0 are given"),
        (written(POSES[:2], NAMES[:2]), "3 to 200 scans are expected, 2 are given"),
        (written(POSES, NAMES[:-1] + ["scan_9.ply"]), "there is no file 'scan_9.ply'"),
        (written(POSES, NAMES[:-1] + NAMES[:1]), "'scan_0.ply' is listed more than once"),
        (
            written(POSES, NAMES) + f'[[scan]]\nfile = "{NAMES[0]}"\n',
            "key scan[9].T_model_scanner: is missing",
        ),
        (
            written(POSES, NAMES).replace(REGION, "low_mm = [200, 0, 0]\nhigh_mm = [250, 9, 9]\n"),
            "scan_0.ply: no point of it lies in the region; in the model's frame its points are",
        ),
        (
            written([T.inverse() for T in POSES], NAMES),
            "scan_0.ply: no point of it lies in the region",
        ),
        (
            written(POSES, NAMES).replace("[[scan]]", 'unit = "mm"\n[[scan]]', 1),
            "scan_0.ply: the furthest point is 0.000",
        ),
        (written(moved(3, 0.01), NAMES), "scan_3.ply: where it shows the part other scans look"),
        (
            written([POSES[1], POSES[0], *POSES[2:]], NAMES),
            "its points; is its pose right?",
        ),
    ],
    ids=[
        "no scans",
        "two scans",
        "no such file",
        "a file twice",
        "no pose",
        "region elsewhere",
        "inverse poses",
        "wrong unit",
        "one pose 10 mm off",
        "two poses swapped",
    ],
)  # fmt: skip
def test_views_that_are_wrong_are_refused(merge, folder, tmp_path, views, says):
    (folder / "views.toml").write_text(views)
    said = merge(folder)
    assert said.code == 2 and says in said.problem, said
    assert not (tmp_path / "model.ply").exists()


def test_a_file_that_is_no_scan_is_named(merge, folder):
    (folder / NAMES[3]).write_text("no cloud")
    said = merge(folder)
    assert said.code == 2 and "scan_3.ply: is neither a PLY nor a PCD file" in said.problem


def test_scans_that_show_no_place_in_common_are_refused(merge, folder):
    # Three sides of something, each of which shows what the others do not.
    across = np.arange(-15, 15) / 1000
    x, y = (values.ravel() for values in np.meshgrid(across, across))
    side = Scan(np.column_stack([x, y, np.full(x.size, 0.55)]), pin.SE3.Identity(), "a side")
    for name in NAMES[:3]:
        write_cloud(folder / name, side)
    wide = "low_mm = [-100, -100, 0]\nhigh_mm = [150, 100, 120]\n"
    views = written([turned(0), turned(2), turned(4)], NAMES[:3])
    (folder / "views.toml").write_text(views.replace(REGION, wide))
    said = merge(folder)
    assert said.code == 2 and "no two scans show the same place of the part" in said.problem


def test_what_is_typed_wrongly_is_one_line(say, merge, taken, tmp_path):
    assert "holds no views.toml" in merge(tmp_path / "nowhere").problem
    assert "holds no views.toml" in merge(taken / NAMES[0]).problem
    assert "--tolerance-mm" in merge(taken, "--tolerance-mm", "nan").problem
    assert "--voxel-mm" in merge(taken, "--voxel-mm", 0).problem

    def to(name: str) -> str:
        return say("part", "from-scans", taken, "--out", tmp_path / name, *COARSE).problem

    assert "one of .ply, .stl" in to("model.obj")
    assert "there is no folder" in to("nowhere/model.ply")
    (tmp_path / "model.ply").touch()
    assert "is there already; choose another name" in to("model.ply")
