"""Pairs of poses of other programs: each format read as the same poses, and what is wrong named."""

import numpy as np
import pinocchio as pin
import pytest
import yaml
from scipy.spatial.transform import Rotation

from workbench.formats.poses.conventions import convention
from workbench.formats.poses.hand_eye import read_pairs, write_scanner_pose
from workbench.model.errors import InputError


@pytest.fixture
def pairs():
    draw, turns = np.random.default_rng(4), Rotation.random(10, rng=4).as_matrix()
    Ts = [pin.SE3(R, draw.uniform(-1, 1, 3)) for R in turns]
    return list(zip(Ts[:5], Ts[5:], strict=True))


def same(read, pairs, atol=1e-6):
    assert len(read) == len(pairs)
    for pair, (flange, target) in zip(read, pairs, strict=True):
        assert np.allclose(pair.T_base_flange.homogeneous, flange.homogeneous, atol=atol)
        assert np.allclose(pair.T_camera_target.homogeneous, target.homogeneous, atol=atol)


def numbers(values):
    return ",".join(f"{value:.9f}" for value in values)


def opencv(name, T):
    data = ", ".join(f"{value:.9f}" for value in T.homogeneous.ravel())
    return f"{name}: !!opencv-matrix\n   rows: 4\n   cols: 4\n   dt: d\n   data: [ {data} ]\n"


def transform(T):
    x, y, z, qx, qy, qz, qw = map(float, pin.SE3ToXYZQUAT(T))
    return {
        "translation": {"x": x, "y": y, "z": z},
        "rotation": {"x": qx, "y": qy, "z": qz, "w": qw},
    }


def zivid(T):
    matrix = T.homogeneous.copy()
    matrix[:3, 3] *= 1000
    rows = ", ".join(f"[{', '.join(map(str, row))}]" for row in matrix)
    return (
        f"__version__:\n    serializer: 1\n    data: 1\nFloatMatrix:\n    Data:\n        [{rows}]\n"
    )


@pytest.mark.parametrize("form", ["quaternions", "matrices"])
def test_rows_of_a_csv_file_are_pairs(tmp_path, pairs, form):
    lines = ["flange x,y,z,...,target", "", "# taken on Monday"]
    for pair in pairs:
        values = [
            pin.SE3ToXYZQUAT(T) if form == "quaternions" else T.homogeneous[:3].ravel()
            for T in pair
        ]
        lines.append(numbers(np.concatenate(values)))
    path = tmp_path / "pairs.csv"
    path.write_text("\n".join(lines))
    same(read_pairs(path), pairs)


@pytest.mark.parametrize("both", [True, False])
def test_flange_poses_are_read_as_the_pendant_shows_them(tmp_path, pairs, both):
    kuka = convention("kuka")
    rows: list[str] = []
    for flange, target in pairs:
        seen = kuka.show(target) if both else pin.SE3ToXYZQUAT(target)
        rows.append(" ".join(map(str, [*kuka.show(flange), *seen])))
    path = tmp_path / "pairs.txt"
    path.write_text("\n".join(rows))
    same(read_pairs(path, written=kuka), pairs)


def test_with_abb_seven_numbers_of_a_target_are_in_its_form_or_refused(tmp_path, pairs):
    abb, path = convention("abb"), tmp_path / "pairs.csv"

    def row(seen: list[float]) -> str:
        return ",".join(map(str, [*abb.show(flange), *seen]))

    flange, target = pairs[0]
    x, y, z, w = pin.Quaternion(target.rotation).coeffs()
    path.write_text(row(abb.show(target)))
    same(read_pairs(path, written=abb), pairs[:1])
    path.write_text(row(target.homogeneous.ravel().tolist()))
    same(read_pairs(path, written=abb), pairs[:1])
    path.write_text(row([*target.translation, x, y, z, w]))
    with pytest.raises(InputError, match=r"line 1: the target is .* mm from the camera"):
        read_pairs(path, written=abb)


def test_matrices_of_opencv_are_read(tmp_path, pairs):
    text = "%YAML:1.0\nframeCount: 5\n"
    for number, (flange, target) in enumerate(pairs):
        text += opencv(f"T1_{number}", flange) + opencv(f"T2_{number}", target)
    path = tmp_path / "TransformPairsInput.yml"
    path.write_text(text)
    same(read_pairs(path), pairs)


def test_samples_of_moveit_are_read(tmp_path, pairs):
    path = tmp_path / "samples.yaml"
    names = ("effector_wrt_world", "object_wrt_sensor")
    found = [
        {name: T.homogeneous.ravel().tolist() for name, T in zip(names, pair, strict=True)}
        for pair in pairs
    ]
    path.write_text(yaml.safe_dump(found))
    same(read_pairs(path), pairs)


@pytest.mark.parametrize("in_hand", [True, False])
def test_samples_of_easy_handeye_are_turned_round_where_the_scanner_stands(
    tmp_path, pairs, in_hand
):
    path = tmp_path / "my.samples.yaml"
    found = [
        {
            "robot": transform(flange if in_hand else flange.inverse()),
            "tracking": transform(target),
        }
        for flange, target in pairs
    ]
    path.write_text(yaml.safe_dump({"samples": found}))
    same(read_pairs(path, in_hand=in_hand), pairs)


def test_a_folder_of_zivid_is_read_without_poses_that_saw_no_board(tmp_path, pairs):
    for number, (flange, target) in enumerate(pairs):
        (tmp_path / f"robot_pose_{number}.yaml").write_text(zivid(flange))
        if number != 2:
            board = tmp_path / f"checkerboard_pose_in_camera_frame_{number}.yaml"
            board.write_text(zivid(target))
    same(read_pairs(tmp_path), [pair for number, pair in enumerate(pairs) if number != 2])


def test_millimetres_are_read_and_asked_for(tmp_path, pairs):
    far = [[pin.SE3(T.rotation, T.translation * 1000) for T in pair] for pair in pairs]
    rows = [numbers(np.concatenate([pin.SE3ToXYZQUAT(T) for T in pair])) for pair in far]
    path = tmp_path / "pairs.csv"
    path.write_text("\n".join(rows))
    same(read_pairs(path, unit=0.001), pairs)
    with pytest.raises(InputError, match="are its lengths millimetres"):
        read_pairs(path)


@pytest.mark.parametrize(
    ("name", "content", "says"),
    [
        ("a.csv", "x,y\n1,2,3\n", "line 2: 3 numbers; a pair has 14, 24 or 32"),
        ("a.csv", "0,0,0,0,0,0,1,0,0,0,0,0,0,1\nx\n", "line 2: 'x' is no number"),
        ("a.csv", "0,0,0,0,0,0,2,0,0,0,0,0,0,1\n", "line 1: the quaternion 0, 0, 0, 2 has"),
        ("a.csv", "", "no pair of a flange pose and a target pose was found"),
        ("a.yaml", "a: [1", "no YAML that can be read"),
        ("a.yaml", "- 1\n- 2\n", "no pair of a flange pose"),
        ("a.yaml", "a: &a [1, 2]\nb: *a\n", "an alias is not allowed"),
        ("a.yaml", "!!python/object/apply:os.getcwd []\n", "no YAML that can be read"),
        ("a.yaml", "T1_0: [1, 2]\nT2_0: [1]\n", "T1_0 is no pose: a matrix has 12 or 16 numbers"),
        ("a.yaml", f"T1_0: {np.eye(4).tolist()}\n", "T2_0 is no pose"),
        ("a.yaml", "- robot: {translation: {x: 1}}\n", "pair 1, robot is no pose"),
        ("a.yaml", "- effector_wrt_world: [a, b]\n", "effector_wrt_world is no pose"),
    ],
)
def test_what_is_no_pair_is_named_with_its_place(tmp_path, name, content, says):
    path = tmp_path / name
    path.write_text(content)
    with pytest.raises(InputError) as refused:
        read_pairs(path)
    assert says in str(refused.value) and str(path) in str(refused.value)


@pytest.mark.parametrize("in_hand", [True, False])
@pytest.mark.parametrize("style", ["opencv", "ros", "zivid"])
def test_the_scanner_is_written_for_other_programs(tmp_path, pairs, style, in_hand):
    T, path = pairs[0][0], tmp_path / "scanner.yaml"
    write_scanner_pose(path, T, style, in_hand=in_hand)
    text = path.read_text()
    if style == "opencv":
        cv2 = pytest.importorskip("cv2")
        name = "T_flange_scanner" if in_hand else "T_base_scanner"
        store = cv2.FileStorage(str(path), cv2.FILE_STORAGE_READ)
        matrix = store.getNode(name).mat()
        assert np.allclose(matrix, T.homogeneous)
        return
    found = yaml.safe_load(text)
    if style == "ros":
        kind = found["parameters"]["calibration_type"]
        assert kind == ("eye_in_hand" if in_hand else "eye_on_base")
        turn, shift = found["transform"]["rotation"], found["transform"]["translation"]
        read = pin.XYZQUATToSE3(np.array([*(shift[k] for k in "xyz"), *(turn[k] for k in "xyzw")]))
        assert np.allclose(read.homogeneous, T.homogeneous)
    else:
        matrix = np.array(found["FloatMatrix"]["Data"])
        assert np.allclose(matrix[:3, 3], T.translation * 1000)
        assert np.allclose(matrix[:3, :3], T.rotation) and matrix[3].tolist() == [0, 0, 0, 1]
