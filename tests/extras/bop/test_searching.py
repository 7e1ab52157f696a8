"""The localizer on a data set in BOP's layout, rendered by the simulated scanner."""

import json
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from bop_set import write_bop_set

from workbench.cli.main import main
from workbench.extras.bop.results import read_results, write_results
from workbench.extras.bop.searching import DataSet, figures_of, place_of
from workbench.formats.cells.reading import read_cell
from workbench.formats.parts.reading import read_part
from workbench.model.errors import InputError
from workbench.model.geometry import pose_from_rpy
from workbench.model.scan import ALL_KINDS
from workbench.perception.simulation.piles import pile_of
from workbench.perception.simulation.synthesize import synthesize

NUMBERS = {"bracket": 3, "bolt": 14}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    cell = replace(read_cell("yumi"), parts=tuple(map(read_part, NUMBERS)))
    truth = pile_of(cell, ALL_KINDS, 4, seed=6)
    # As on a table: walls stand outside of the picture.
    cell = replace(cell, bin=replace(cell.bin, size=np.array([1.0, 1.0, 0.01])), fixtures=())
    folder = tmp_path_factory.mktemp("bop") / "set"
    write_bop_set(folder, cell, NUMBERS, [(synthesize(cell, truth, seed=6), truth)])
    return folder


@pytest.fixture(scope="module")
def data(folder):
    return DataSet.read(folder, "test", "models", "", 0)


@pytest.mark.parametrize("where", [[], ["--own-bin"]])
def test_what_lies_in_a_data_set_is_found_and_measured(where, folder, tmp_path, capsys):
    out = tmp_path / "ours.csv"
    assert main(["study", "bop", str(folder), *where, "--out", str(out), "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert (said["images"], said["seconds"] > 0) == (1, True)
    assert {name: one["targets"] for name, one in said["objects"].items()} == {"3": 2, "14": 2}
    # All four are found, within 5 % of their diameters, 2 mm and 5 px.
    assert said["mssd"] == said["mssd_mm"] == said["mspd"] == said["bop24"] == 1.0
    # The same from the file that was written, as anybody else's would be measured.
    assert main(["study", "bop", str(folder), "--results", str(out), "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == said


def test_the_table_has_a_row_for_each_object_and_one_for_all(folder, data, tmp_path, capsys):
    write_results(tmp_path / "none.csv", [])
    assert main(["study", "bop", str(folder), "--results", str(tmp_path / "none.csv")]) == 0
    said = capsys.readouterr().out
    assert "1 images, 0 found" in said
    assert [row.split()[1] for row in said.splitlines() if "0.000" in row] == ["14", "3", "all"]


def true_results(data, tmp_path, off=(0.0, 0.0, 0.0), turn=0.0):
    path = tmp_path / "true.csv"
    moved = pose_from_rpy((0, 0, 0), (0, 0, turn))
    lines = ["scene_id,im_id,obj_id,score,R,t,time"]
    for image in data.images:
        for one in image.truth:
            T = pin.SE3(one.T_camera_object.rotation, one.T_camera_object.translation + off) * moved
            R = " ".join(map(str, T.rotation.ravel()))
            t = " ".join(map(str, T.translation * 1000))
            lines.append(f"{image.scene},{image.number},{one.object},0.5,{R},{t},-1")
    path.write_text("\n".join(lines))
    return read_results(path)


def test_the_truth_is_right_and_the_further_off_the_less(data, tmp_path):
    assert figures_of(data, true_results(data, tmp_path))["bop24"] == 1.0
    figures = figures_of(data, true_results(data, tmp_path, off=(0.0, 0.0, 0.0101)))
    # Right at 12, 14, 16, 18 and 20 mm.
    assert figures["mssd_mm"] == pytest.approx(0.5)
    assert figures["seconds"] is None


def test_symmetries_of_the_models_count(data, tmp_path):
    # A sixth turn: the bolt's head has six sides, the bracket is another one after it.
    figures = figures_of(data, true_results(data, tmp_path, turn=np.pi / 3))
    assert figures["objects"]["14"]["mssd"] == 1.0
    assert figures["objects"]["3"]["mssd"] < 0.5


def test_an_object_that_nobody_knows_is_refused(data, tmp_path):
    (one, *_) = true_results(data, tmp_path)
    with pytest.raises(InputError, match="object 99 was found"):
        figures_of(data, [replace(one, object=99)])


def test_objects_without_a_model_and_sets_without_poses_are_refused(folder, tmp_path):
    (tmp_path / "test").symlink_to(folder / "test")
    (tmp_path / "models").mkdir()
    infos = json.loads((folder / "models" / "models_info.json").read_text())
    del infos["3"]
    (tmp_path / "models" / "models_info.json").write_text(json.dumps(infos))
    (tmp_path / "models" / "obj_000014.ply").symlink_to(folder / "models" / "obj_000014.ply")
    with pytest.raises(InputError, match="object 3 lies in a scene and has no model"):
        DataSet.read(tmp_path, "test", "models", "", 0)


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["nowhere"], "nowhere/models/models_info.json: No such file"),
        (["{folder}", "--split", "train"], "train: holds no scenes"),
        (["{folder}", "--sensor", "photoneo"], "scene_camera_photoneo.json are expected"),
        (["{folder}", "--models", "cad"], "cad/models_info.json: No such file"),
        (["{folder}", "--results", "nowhere.csv"], "nowhere.csv: No such file"),
        (["{folder}", "--images", "-1"], "--images must be a whole number"),
    ],
)
def test_bad_input_is_one_sentence(folder, arguments, says, capsys):
    typed = [argument.format(folder=folder) for argument in arguments]
    assert main(["study", "bop", *typed]) == 2
    said = capsys.readouterr().err
    assert says in said and said.count("\n") == 1


@pytest.mark.parametrize("tilt", [0.0, 0.5])
def test_things_are_looked_for_above_the_plane_that_most_lies_on(tilt):
    generator = np.random.default_rng(0)
    T_camera_floor = pose_from_rpy((0, 0.1, 1.0), (np.pi + tilt, 0, 0.3))
    floor = np.column_stack([generator.uniform(-0.3, 0.3, (3000, 2)), np.zeros(3000)])
    heap = generator.uniform((-0.05, -0.05, 0.0), (0.05, 0.05, 0.08), (800, 3))
    points = np.vstack([floor, heap]) @ T_camera_floor.rotation.T + T_camera_floor.translation
    points += generator.normal(0, 0.0003, points.shape)
    bin = place_of(points, 0)
    up = T_camera_floor.rotation[:, 2]
    assert bin.T_world_bin.rotation[:, 2] @ up > np.cos(np.deg2rad(1.0))
    T_bin_floor = bin.T_world_bin.actInv(T_camera_floor)
    assert abs(T_bin_floor.translation[2]) < 0.003
    assert 0.08 < bin.size[2] < 0.15
