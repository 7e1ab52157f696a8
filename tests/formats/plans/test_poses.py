import json
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mutations import mutated, only_file_errors

from workbench.formats.files.toml_keys import Table
from workbench.formats.plans.pose_files import (
    POSES_FORMAT,
    read_detection,
    read_poses,
    write_poses,
)
from workbench.model.digest import canonical, digest_of
from workbench.model.errors import FileError
from workbench.model.geometry import pose_from_rpy
from workbench.model.recipes.joint import PlacingError
from workbench.model.scan import Detection

T = pose_from_rpy([0.41, -0.07, 0.0165], (np.pi / 2, 0.1, 0.4))


def halcon(*poses: pin.SE3, digits: int = 15) -> str:
    """What HALCON's write_tuple makes of poses, in millimetres."""
    numbers = [
        float(value) * (1000 if column == 3 else 1)
        for pose in poses
        for row in pose.homogeneous[:3]
        for column, value in enumerate(row)
    ]
    return "\n".join([str(len(numbers)), *(f"2 {number:.{digits}g}" for number in numbers), ""])


def written(tmp_path: Path, content: str | bytes) -> Path:
    path = tmp_path / "Poses.txt"
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


def with_line(content: str, number: int, line: str) -> str:
    lines = content.splitlines()
    lines[number - 1] = line
    return "\n".join(lines)


def test_halcon_poses_are_rows_in_millimetres(tmp_path: Path) -> None:
    other = pose_from_rpy([0.3, 0.2, -0.1], (0.1, 0.2, 0.3))
    first, second = read_poses(written(tmp_path, halcon(T, other)), "peg")
    assert first.part == second.part == "peg"
    np.testing.assert_allclose(first.T_world_part.homogeneous, T.homogeneous, atol=1e-12)
    np.testing.assert_allclose(second.T_world_part.homogeneous, other.homogeneous, atol=1e-12)


def test_integers_windows_lines_and_a_missing_last_line_end_are_halcon_too(tmp_path: Path) -> None:
    numbers = ["1 1", "1 0", "2 0", "2 410.0", "1 0", "1 1", "1 0", "2 -7e1", "1 0", "1 0", "1 +1"]
    text = "\r\n".join(["12", *numbers, "1 5"])
    (found,) = read_poses(written(tmp_path, text), "peg")
    assert found.T_world_part.translation.tolist() == [0.41, -0.07, 0.005]
    assert np.array_equal(found.T_world_part.rotation, np.eye(3))


def test_few_digits_make_a_true_rotation(tmp_path: Path) -> None:
    (found,) = read_poses(written(tmp_path, halcon(T, digits=4)), "peg")
    R = found.T_world_part.rotation
    np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-12)


def test_no_parts_are_no_detections(tmp_path: Path) -> None:
    assert read_poses(written(tmp_path, "0\n"), "peg") == ()


HALCON = halcon(T)
BAD_HALCON = {
    "count too large": (with_line(HALCON, 1, "24"), "line 1 promises 24 numbers, 12 lines follow"),
    "count too small": (HALCON + HALCON[3:], "line 1 promises 12 numbers, 24 lines follow"),
    "not a multiple": (with_line(HALCON, 1, "11"), "count of 11 numbers; expected a multiple"),
    "absurd count": (with_line(HALCON, 1, "999999999996"), "a multiple of 12 up to 12000"),
    "negative count": (with_line(HALCON, 1, "-12"), "line 1 must be the count of numbers, not"),
    "no count": (HALCON[3:], "line 1 must be the count of numbers, not '2 "),
    "empty": ("", "is empty"),
    "text": (with_line(HALCON, 5, '3 "410"'), "line 5: .*texts"),
    "NaN": (with_line(HALCON, 5, "2 nan"), "line 5: 'nan' is not a finite real number"),
    "infinite": (with_line(HALCON, 5, "2 1e999"), "line 5: '1e999' is not a finite"),
    "underscore": (with_line(HALCON, 5, "2 4_1"), "line 5: '4_1' is not"),
    "fraction as integer": (with_line(HALCON, 5, "1 0.5"), "line 5: '0.5' is not an integer"),
    "no type": (with_line(HALCON, 5, "410.0"), "line 5: '410.0' must be `1 integer` or"),
    "two values": (with_line(HALCON, 5, "2 1 2"), "line 5: '1 2' is not a finite"),
    "long number": (with_line(HALCON, 5, "2 " + "9" * 5000), "line 5: '99"),
    "no rotation": (with_line(HALCON, 2, "2 7"), "pose 1: .* is not a rotation"),
    "mirror": (halcon(T).replace("\n2 ", "\n2 -").replace("--", ""), "is not a rotation"),
    "binary": (b"12\n2 \x00\xff\xfe", "it is not a text"),
    "NUL": (with_line(HALCON, 5, "2 \x00"), "line 5: .* is not a finite"),
    "micrometres": (with_line(HALCON, 5, "2 410000"), "pose 1: is 410 m away"),
}


@pytest.mark.parametrize("bad", BAD_HALCON)
def test_a_bad_halcon_file_is_refused_with_its_line(tmp_path: Path, bad: str) -> None:
    content, message = BAD_HALCON[bad]
    with pytest.raises(FileError, match=message):
        read_poses(written(tmp_path, content), "peg")


def test_a_file_that_is_not_there_is_refused(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="No such file"):
        read_poses(tmp_path / "none.json", "peg")


def test_a_device_without_an_end_is_refused() -> None:
    with pytest.raises(FileError, match="is longer than 4 MB"):
        read_poses("/dev/zero", "peg")


def test_our_poses_come_back_with_their_digests(
    detections: tuple[Detection, ...], tmp_path: Path
) -> None:
    write_poses(tmp_path / "poses.json", detections)
    assert digest_of(read_poses(tmp_path / "poses.json", "any")) == digest_of(detections)


def test_how_sure_a_part_is_comes_back_too_and_is_left_out_where_nobody_knows(
    tmp_path: Path,
) -> None:
    plain = Detection("peg", T)
    sure = Detection(
        "peg", T, covariance=np.diag([1e-8, 2e-8, 3e-8, 1e-6, 2e-6, 3e-6]), probability=0.9
    )
    write_poses(tmp_path / "poses.json", (plain, sure))
    first, second = read_poses(tmp_path / "poses.json", "any")
    assert digest_of((first, second)) == digest_of((plain, sure))
    assert digest_of(first) != digest_of(second)
    assert first.covariance is first.probability is first.deviations is None
    assert second.deviations == pytest.approx((np.sqrt(3e-8), np.sqrt(3e-6)))
    assert (tmp_path / "poses.json").read_text().count("covariance") == 1


def test_the_axis_of_an_unknown_roll_comes_back(tmp_path: Path) -> None:
    axis = np.array([[0.001, 0.0, 0.0], [0.0, 0.6, 0.8]])
    rolled = (Detection("peg", T, roll_known=False, roll_axis=axis), Detection("peg", T))
    write_poses(tmp_path / "poses.json", rolled)
    first, second = read_poses(tmp_path / "poses.json", "any")
    assert digest_of((first, second)) == digest_of(rolled)
    assert first.roll_axis is not None and np.array_equal(first.roll_axis, axis)
    assert second.roll_axis is None


FULL = {
    "part": "peg",
    "T_world_part": T,
    "score": 0.8,
    "visible": 0.7,
    "gap": 0.1,
    "residual": 0.0002,
    "roll_known": False,
    "covariance": np.diag([1e-8, 2e-8, 3e-8, 1e-6, 2e-6, 3e-6]),
    "probability": 0.9,
    "roll_axis": np.array([[0.001, 0.0, 0.0], [0.0, 0.6, 0.8]]),
    "T_world_found": T * T,
    "by_colour": False,
    "placing": PlacingError(np.eye(6), np.diag([1e-8, 2e-8, 3e-8, 1e-6, 2e-6, 3e-6])),
    "T_world_seen": T,
}


def test_every_field_of_a_detection_comes_back() -> None:
    assert list(FULL) == [field.name for field in fields(Detection)]
    for by_colour in (False, True):
        found = Detection(**{**FULL, "by_colour": by_colour})
        table = Table(Path("plan.json"), canonical(found))
        again = read_detection(table, complete=True)
        assert canonical(again) == canonical(found)
        assert canonical(found).keys() == FULL.keys()


def test_by_what_a_part_was_told_apart_comes_back_from_a_file(tmp_path: Path) -> None:
    coloured = tuple(Detection("peg", T, by_colour=by) for by in (True, False, None))
    write_poses(tmp_path / "poses.json", coloured)
    assert [found.by_colour for found in read_poses(tmp_path / "poses.json", "any")] == [
        True,
        False,
        None,
    ]


def test_part_and_pose_are_enough(tmp_path: Path) -> None:
    pose = {"part": "peg", "T_world_part": T.homogeneous[:3].tolist(), "gap": None}
    path = written(tmp_path, json.dumps({"format": POSES_FORMAT, "detections": [pose]}))
    (found,) = read_poses(path, "other")
    assert (found.part, found.score, found.gap, found.roll_known) == ("peg", 1.0, None, True)


def ours(**changes: Any) -> str:
    pose = {"part": "peg", "T_world_part": T.homogeneous.tolist(), **changes}
    return json.dumps({"format": POSES_FORMAT, "detections": [pose]})


BAD_JSON = {
    "format": (json.dumps({"detections": []}), "key format: is missing"),
    "no detections": (json.dumps({"format": POSES_FORMAT}), "key detections: is missing"),
    "not a list": (json.dumps({"format": POSES_FORMAT, "detections": {}}), "an array of tables"),
    "too many": (
        json.dumps({"format": POSES_FORMAT, "detections": [{}] * 1001}),
        "1001 are given, at most 1000",
    ),
    "unknown key": (ours(scor=1), r"detections\[1\]\.scor: is not known.*did you mean 'score'"),
    "score": (ours(score="high"), r"detections\[1\]\.score: a number is expected, 'high'"),
    "covariance of five": (ours(covariance=np.eye(6)[:5].tolist()), "covariance: is no covariance"),
    "crooked covariance": (ours(covariance=np.triu(np.ones((6, 6))).tolist()), "is no covariance"),
    "negative covariance": (ours(covariance=(-np.eye(6)).tolist()), "is no covariance"),
    "huge covariance": (ours(covariance=[[1e308, -1e308] * 3] * 6), "covariance: reaches 1e\\+308"),
    "empty covariance": (ours(covariance=[]), "covariance"),
    "axis of one row": (ours(roll_axis=[[0, 0, 1]]), "roll_axis: is no axis"),
    "long axis": (ours(roll_axis=[[0, 0, 0], [0, 0, 2]]), "roll_axis: is no axis"),
    "probability": (ours(probability=1.5), r"detections\[1\]\.probability"),
    "NaN": (ours(score=float("nan")), "NaN is not a JSON number"),
    "shape": (ours(T_world_part=[[1, 0, 0, 0]]), r"needs a 3 x 4 or 4 x 4 matrix"),
    "short row": (ours(T_world_part=[[1, 0, 0]]), r"T_world_part\[1\]: 4 numbers are expected, 3"),
    "empty part": (ours(part=""), "part: is an empty text"),
    "surrogate": (ours(part="\ud800"), "cannot be printed"),
    "huge integer": ('{"format": ' + "9" * 5000 + "}", "is not valid JSON"),
    "cut off": (ours()[:-3], "is not valid JSON: .* line 1"),
    "deep": ('{"format":' * 100_000, "is nested too deeply"),
}


@pytest.mark.parametrize("bad", BAD_JSON)
def test_bad_poses_of_ours_are_refused_with_their_key(tmp_path: Path, bad: str) -> None:
    content, message = BAD_JSON[bad]
    with pytest.raises(FileError, match=message):
        read_poses(written(tmp_path, content), "peg")


def test_a_score_that_is_not_finite_is_not_written(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="not finite"):
        write_poses(tmp_path / "poses.json", [Detection("peg", T, score=float("inf"))])
    assert not (tmp_path / "poses.json").exists()


angles = st.tuples(*[st.floats(-3.2, 3.2)] * 3)
places = st.tuples(*[st.floats(-19, 19)] * 3)


@settings(
    deadline=None, suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture]
)
@given(poses=st.lists(st.tuples(places, angles), max_size=4))
def test_any_poses_survive_both_kinds_of_file(tmp_path: Path, poses: Any) -> None:
    made = [Detection("peg", pose_from_rpy(xyz, rpy)) for xyz, rpy in poses]
    write_poses(tmp_path / "poses.json", made)
    assert digest_of(read_poses(tmp_path / "poses.json", "any")) == digest_of(made)
    text = halcon(*(found.T_world_part for found in made), digits=17)
    for found, origin in zip(read_poses(written(tmp_path, text), "peg"), made, strict=True):
        assert found.T_world_part.isApprox(origin.T_world_part, 1e-12)


@settings(
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
    max_examples=300,
)
@given(data=st.data())
def test_only_file_errors_come_out_of_broken_pose_files(
    tmp_path: Path, data: st.DataObject
) -> None:
    valid = data.draw(st.sampled_from([HALCON, ours(score=0.5, gap=None)])).encode()
    content = data.draw(mutated(valid))
    only_file_errors(tmp_path / "poses", content, lambda path: read_poses(path, "peg"))
