"""Data sets in BOP's layout, and its results: what is read, and what is refused."""

import json
from pathlib import Path

import numpy as np
import pytest
import trimesh
from bop_set import write_models
from hypothesis import given, settings
from hypothesis import strategies as st
from mutations import mutated, only_file_errors
from PIL import Image

from workbench.extras.bop.models import read_models
from workbench.extras.bop.results import HEADER, PoseEstimate, read_results, write_results
from workbench.extras.bop.scenes import BopImage, read_depth, read_images
from workbench.formats.parts.reading import read_part
from workbench.model.errors import FileError
from workbench.model.geometry import pose_from_rpy

CAMERA = {"cam_K": [600, 0, 320, 0, 600, 240, 0, 0, 1], "depth_scale": 0.1}
TRUE = {"cam_R_m2c": [1, 0, 0, 0, 1, 0, 0, 0, 1], "cam_t_m2c": [10, 20, 900], "obj_id": 5}
ESTIMATE = PoseEstimate(1, 2, 3, 0.75, pose_from_rpy((0.01, -0.02, 0.9), (0.1, 0.2, 0.3)), 0.5)


def scene(folder: Path, **changes: object) -> Path:
    """A data set of one image, with changes of its camera, pose or depth."""
    place = folder / "test" / "000007"
    (place / "depth").mkdir(parents=True)
    contents = {
        "camera": {"0": CAMERA | changes.pop("camera", {})},
        "gt": {"0": [TRUE | changes.pop("gt", {})]},
        "gt_info": {"0": [{"visib_fract": 0.4}]},
    }
    for name, content in contents.items():
        (place / f"scene_{name}.json").write_text(json.dumps(content))
    Image.fromarray(np.full((4, 6), changes.pop("depth", 9000), np.uint16)).save(
        place / "depth" / "000000.png"
    )
    assert not changes
    return folder


def test_results_are_the_same_again(tmp_path):
    path = tmp_path / "ours_set-test.csv"
    write_results(path, [ESTIMATE, ESTIMATE])
    lines = path.read_text().splitlines()
    assert (lines[0], len(lines)) == (HEADER, 3)
    (one, _) = read_results(path)
    assert (one.scene, one.image, one.object, one.score, one.seconds) == (1, 2, 3, 0.75, 0.5)
    assert np.allclose(one.T_camera_object.homogeneous, ESTIMATE.T_camera_object.homogeneous)
    assert [float(x) for x in lines[1].split(",")[5].split()] == pytest.approx([10, -20, 900])


def test_a_file_without_a_header_is_read_too(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("1,2,3,0.5,1 0 0 0 1 0 0 0 1,0 0 500,-1\n\n")
    (one,) = read_results(path)
    assert (one.seconds, one.T_camera_object.translation[2]) == (-1, 0.5)


@pytest.mark.parametrize(
    ("line", "says"),
    [
        ("1,2,3,0.5,1 0 0 0 1 0 0 0 1,0 0 500", "scene_id,im_id,obj_id"),
        ("1,2,x,0.5,1 0 0 0 1 0 0 0 1,0 0 500,-1", "line 2"),
        ("1,2,3,nan,1 0 0 0 1 0 0 0 1,0 0 500,-1", "finite"),
        ("1,2,3,0.5,1 0 0 0 1 0 0 0,0 0 500,-1", "line 2"),
        ("1,2,3,0.5,2 0 0 0 1 0 0 0 1,0 0 500,-1", "not a rotation"),
        ("1,2,3,0.5,1 0 0 0 1 0 0 0 1,0 inf 500,-1", "not a finite"),
    ],
)
def test_broken_results_name_the_line(tmp_path, line, says):
    path = tmp_path / "a.csv"
    path.write_text(f"{HEADER}\n{line}\n")
    with pytest.raises(FileError, match=says):
        read_results(path)


@given(st.data())
@settings(max_examples=60, deadline=None)
def test_no_results_are_worse_than_refused(tmp_path_factory, data):
    path = tmp_path_factory.mktemp("results") / "a.csv"
    write_results(path, [ESTIMATE])
    only_file_errors(path, data.draw(mutated(path.read_bytes())), read_results)


def test_an_image_has_a_camera_true_poses_and_depths(tmp_path):
    (image,) = read_images(scene(tmp_path), "test")
    assert (image.scene, image.number, image.unit) == (7, 0, pytest.approx(1e-4))
    (one,) = image.truth
    assert (one.object, one.visible) == (5, 0.4)
    assert one.T_camera_object.translation == pytest.approx([0.01, 0.02, 0.9])
    depths = read_depth(image)
    assert depths.shape == (4, 6)
    assert depths == pytest.approx(0.9)


def test_the_targets_say_which_images_count(tmp_path):
    scene(tmp_path)
    targets = tmp_path / "test_targets_bop19.json"
    targets.write_text('[{"scene_id": 7, "im_id": 1, "obj_id": 5, "inst_count": 1}]')
    assert read_images(tmp_path, "test") == []
    targets.write_text('[{"scene_id": 7, "im_id": 0}]')
    assert len(read_images(tmp_path, "test")) == 1


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"camera": {"cam_K": [1, 2, 3]}}, "9 numbers are expected"),
        ({"camera": {"cam_K": [0] * 9}}, "no camera matrix"),
        ({"camera": {"depth_scale": 0}}, "depth_scale"),
        ({"gt": {"cam_R_m2c": [2, 0, 0, 0, 1, 0, 0, 0, 1]}}, "not a rotation"),
        ({"gt": {"cam_t_m2c": [0, 0, 900_000]}}, "has to be in millimetres"),
        ({"gt": {"obj_id": "five"}}, "a whole number"),
        ({"depth": 0}, "holds no depth"),
        ({"depth": 900}, "depth times depth_scale has to be millimetres"),
        ({"gt": {"cam_t_m2c": [0.01, 0.02, 0.9]}}, "has to be millimetres"),
    ],
)
def test_what_is_wrong_in_a_scene_is_said(tmp_path, changes, says):
    scene(tmp_path, **changes)
    with pytest.raises(FileError, match=says):
        for image in read_images(tmp_path, "test"):
            read_depth(image)


@pytest.mark.parametrize(
    ("name", "content", "says"),
    [
        ("scene_camera.json", b"{", "not valid JSON"),
        ("scene_camera.json", b"[]", "a JSON object is expected"),
        ("scene_camera.json", b'{"a": {}}', "a number is expected as key"),
        ("scene_gt.json", b"{}", "key 0: is missing"),
        ("scene_gt.json", None, "No such file"),
        ("scene_gt_info.json", b'{"0": []}', "1 entries are expected"),
        ("depth/000000.png", b"\x89PNG", "cannot be read as an image"),
        ("depth/000000.png", None, "there is no such depth image"),
    ],
)
def test_missing_and_broken_files_are_named(tmp_path, name, content, says):
    path = scene(tmp_path) / "test" / "000007" / name
    path.unlink()
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(FileError, match=says) as caught:
        for image in read_images(tmp_path, "test"):
            read_depth(image)
    assert "\n" not in str(caught.value)


def test_half_a_picture_and_a_coloured_one_are_no_depths(tmp_path):
    path = scene(tmp_path) / "test" / "000007" / "depth" / "000000.png"
    Image.fromarray(np.arange(40_000, dtype=np.uint16).reshape(200, 200)).save(path)
    path.write_bytes(path.read_bytes()[:200])
    (image,) = read_images(tmp_path, "test")
    with pytest.raises(FileError, match="cannot be read as an image"):
        read_depth(image)
    Image.new("RGB", (4, 4), (9, 9, 9)).save(path)
    with pytest.raises(FileError, match="one channel"):
        read_depth(image)


@given(st.data())
@settings(max_examples=60, deadline=None)
def test_no_depth_image_is_worse_than_refused(tmp_path_factory, data):
    folder = scene(tmp_path_factory.mktemp("bop"))
    (image,) = read_images(folder, "test")
    path = image.depth.with_suffix(".png")
    changed = data.draw(mutated(path.read_bytes()))
    only_file_errors(path, changed, lambda _: read_depth(image))


def test_models_are_read_with_their_symmetries(tmp_path):
    parts = [read_part("bolt"), read_part("keyed_cylinder")]
    write_models(tmp_path / "models", list(enumerate(parts, start=1)))
    models = read_models(tmp_path / "models")
    assert sorted(models) == [1, 2]
    bolt = models[1]
    assert np.ptp(bolt.mesh.points, axis=0) == pytest.approx(np.ptp(parts[0].mesh.points, axis=0))
    theirs, ours = bolt.motions, parts[0].symmetry.motions(1)
    assert len(theirs) == len(ours)
    assert all(np.abs(theirs - M).max(axis=(1, 2)).min() < 1e-9 for M in ours)


def info(tmp_path: Path, **keys: object) -> Path:
    write_models(tmp_path / "models", [(1, read_part("bolt"))])
    path = tmp_path / "models" / "models_info.json"
    content = json.loads(path.read_text())
    content["1"] = {"diameter": content["1"]["diameter"], **keys}
    path.write_text(json.dumps(content))
    return tmp_path / "models"


def test_continuous_symmetries_are_taken_at_315_angles_after_each_discrete_one(tmp_path):
    axis = {"axis": [0, 0, 2], "offset": [10, 0, 0]}
    flip = [1, 0, 0, 0, 0, -1, 0, 0, 0, 0, -1, 5, 0, 0, 0, 1]
    folder = info(tmp_path, symmetries_continuous=[axis], symmetries_discrete=[flip])
    motions = read_models(folder)[1].motions
    assert motions.shape == (630, 4, 4)
    # ceil(pi / 0.01) steps of a whole turn, about an axis through (10, 0, 0) mm.
    step = 2 * np.pi / 315
    assert motions[1][:2, :2] == pytest.approx(
        np.array([[np.cos(step), -np.sin(step)], [np.sin(step), np.cos(step)]])
    )
    assert motions[100] @ [0.01, 0, 0.3, 1] == pytest.approx([0.01, 0, 0.3, 1])
    assert motions[315] @ [0.01, 0.02, 0.03, 1] == pytest.approx([0.01, -0.02, -0.025, 1])


@pytest.mark.parametrize(
    ("keys", "says"),
    [
        ({"diameter": 0.04}, "read as millimetres, but models_info.json says"),
        ({"diameter": "big"}, "a number is expected"),
        ({"symmetries_discrete": [[1, 2, 3]]}, "16 numbers are expected"),
        ({"symmetries_continuous": [{"axis": [0, 0, 0], "offset": [0, 0, 0]}]}, "no direction"),
    ],
)
def test_what_is_wrong_with_a_model_is_said(tmp_path, keys, says):
    with pytest.raises(FileError, match=says):
        read_models(info(tmp_path, **keys))


def test_a_folder_without_models_is_refused(tmp_path):
    folder = info(tmp_path)
    (folder / "obj_000001.ply").unlink()
    with pytest.raises(FileError, match="there is no such file"):
        read_models(folder)
    (folder / "models_info.json").write_text("{}")
    with pytest.raises(FileError, match="names no object"):
        read_models(folder)


def test_models_without_info_get_the_size_of_their_meshes_and_no_symmetry(tmp_path):
    folder = info(tmp_path)
    stated = read_models(folder)[1]
    (folder / "models_info.json").unlink()
    found = read_models(folder)[1]
    assert found.diameter == pytest.approx(stated.diameter, rel=1e-3)
    assert found.motions.tolist() == [np.eye(4).tolist()]


def test_models_without_info_in_metres_are_refused(tmp_path):
    path = info(tmp_path) / "obj_000001.ply"
    path.with_name("models_info.json").unlink()
    mesh = trimesh.load_mesh(path)
    mesh.apply_scale(0.001)
    mesh.export(path)
    with pytest.raises(FileError, match="its lengths must be in millimetres"):
        read_models(path.parent)


def test_no_depth_of_another_kind_is_looked_for(tmp_path):
    image = BopImage(1, 2, np.eye(3), tmp_path / "000002", 0.001, ())
    Image.fromarray(np.full((3, 3), 0.9, np.float32)).save(tmp_path / "000002.tif")
    assert read_depth(image) == pytest.approx(0.9 * 0.001)
