"""`workbench study models`, and `study localization --models` with what it has made, as typed."""

import json

import numpy as np
import pytest
import trimesh

from workbench.formats.meshes.reading import read_mesh
from workbench.formats.parts.reading import read_part

ONE = ("--parts", "bolt", "--ways", "turntable", "--noise", "fine", "--views", 6, "--seed", 7)
PILE = ("study", "localization", "--counts", 1, "--noise", "fine", "--scenes", 1, "--seed", 5)


def test_models_are_made_kept_and_searched_with(say, tmp_path):
    kept = tmp_path / "kept"
    said = say("study", "models", *ONE, "--keep", kept, "--json")
    assert said.code == 0, said.err
    (row,) = json.loads(said.out)["models"]
    assert (row["part"], row["way"], row["build"]) == ("bolt", "turntable", "fine")
    assert row["model"]["median"] < 0.0003 < row["hull"]["median"]
    assert row["model"]["volume"] == pytest.approx(1, abs=0.1) and 0 < row["unseen"] < 0.5
    true, model = read_part("bolt").mesh.points, read_mesh(kept / "bolt.ply", 0.001).points
    assert np.ptp(model, axis=0) == pytest.approx(np.ptp(true, axis=0), abs=0.002)

    said = say(*PILE, "--parts", "bolt", "--models", kept, "--json")
    assert said.code == 0, said.err
    told = json.loads(said.out)
    assert told["scenes"][0]["task"]["models"] == str(kept)
    assert told["rows"][0]["found"] == told["rows"][0]["parts"] == 1
    assert told["rows"][0]["recall"] == 1
    # The mesh in the folder is what is searched with: by one of twice the size nothing is right.
    doubled = tmp_path / "doubled"
    doubled.mkdir()
    trimesh.load_mesh(kept / "bolt.ply").apply_scale(2.0).export(doubled / "bolt.ply")
    said = say(*PILE, "--parts", "bolt", "--models", doubled, "--json")
    assert said.code == 0, said.err
    assert json.loads(said.out)["rows"][0]["recall"] == 0


def test_a_table_is_printed(say):
    said = say("study", "models", *ONE)
    assert said.code == 0, said.err
    assert "Models from 6 scans" in said.out
    assert "bolt" in said.out and "turntable" in said.out


@pytest.mark.parametrize(
    ("typed", "sentence"),
    [
        (("--views", 2), "--views must be a whole number from 3 to 200, not 2"),
        (("--views", 0), "--views"),
        (("--shift-mm", "nan"), "--shift-mm"),
        (("--turn-deg", 90), "--turn-deg"),
        (("--off-mm", 1000), "--off-mm"),
        (("--seed", -1), "--seed"),
        (("--parts", "nothing"), "nothing: no such path, and no such name under parts/"),
        (("--ways", "held", "turntable", "--keep", "kept"), "--keep goes with one of --ways"),
        (("--keep", __file__), "test_models.py"),
    ],
)
def test_what_makes_no_sense_is_refused_in_one_sentence(say, typed, sentence):
    said = say("study", "models", *ONE, *typed)
    assert said.code == 2 and sentence in said.problem


def test_a_pose_that_is_wrong_is_said_to_be_wrong(say, tmp_path):
    said = say("study", "models", *ONE, "--off-mm", 10, "--json")
    (row,) = json.loads(said.out)["models"]
    assert said.code == 0 and "scan 2: where it shows the part other scans" in row["refused"]
    assert "refused: scan 2" in say("study", "models", *ONE, "--off-mm", 10).out
    said = say("study", "models", *ONE, "--off-mm", 10, "--keep", tmp_path / "kept")
    assert said.code == 2 and "is its pose right" in said.problem


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        (None, "bolt.ply: there is no such file"),
        (b"no mesh", "bolt.ply: is cut off, or no PLY file"),
        (b"ply\nformat ascii 1.0\nelement vertex 0\nend_header\n", "bolt.ply"),
    ],
    ids=["no model", "no mesh", "an empty one"],
)
def test_models_that_cannot_be_used_are_named(say, tmp_path, content, sentence):
    if content is not None:
        (tmp_path / "bolt.ply").write_bytes(content)
    said = say(*PILE, "--parts", "bolt", "--models", tmp_path)
    assert said.code == 2 and sentence in said.problem
