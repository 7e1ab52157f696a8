"""A CAD file becomes a part of the cell, as a task, with the files that a shell would have made."""

import shutil
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
import trimesh
from idle import done
from waiting import PATIENCE

from workbench.app.core.cell.changes import SaveCell, UndoCell
from workbench.app.core.cell.making import ImportPart
from workbench.app.core.cycle.scanning import TakeScan
from workbench.app.core.people import Role
from workbench.app.core.state import Phase
from workbench.app.picking.part_import import excess_of
from workbench.app.review.recompute import recompute_tasks
from workbench.app.runtime.bench import Bench
from workbench.app.runtime.effect_runner import EffectRunner
from workbench.formats.cells.reading import cell_path, part_folders, read_cell
from workbench.formats.files.shipped import find
from workbench.formats.parts.reading import read_part
from workbench.journal.journal import Journal
from workbench.model.errors import CommandRefused
from workbench.model.geometry import Mesh, Solid, pose_from_rpy


@pytest.fixture
def own(tmp_path, monkeypatch) -> Path:
    """A working directory with its own cell and parts."""
    for kind, name in (("robots", "yumi"), ("parts", "keyed_cylinder")):
        shutil.copytree(find(kind, name), tmp_path / kind / name)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def bench(own):
    machines = partial(EffectRunner, cell_file=cell_path("yumi"))
    bench = Bench(read_cell("yumi"), Journal(own / "session"), effects=machines)
    yield bench
    bench.close()


def box(sides=(60, 30, 20)) -> np.ndarray:
    return np.frombuffer(trimesh.creation.box(sides).export(file_type="stl"), np.uint8)


def test_pieces_stick_out_by_what_they_fill():
    """Of a corner 10 mm thick, with legs of 40 mm, its hull fills up to 15 mm."""
    outline = np.array([(0, 0), (40, 0), (40, 10), (10, 10), (10, 40), (0, 40)]) / 1000
    floor, top = np.c_[outline, np.zeros(6)], np.c_[outline, np.full(6, 0.02)]
    fans = [(0, k, k + 1) for k in range(1, 5)]
    sides = [t for k in range(6) for n in [(k + 1) % 6] for t in ((k, n, n + 6), (k, n + 6, k + 6))]
    faces = [(c, b, a) for a, b, c in fans] + [(a + 6, b + 6, c + 6) for a, b, c in fans] + sides
    corner = trimesh.Trimesh(np.vstack([floor, top]), faces)
    assert corner.is_volume
    part = read_part(find("parts", "keyed_cylinder"))

    def excess(*bodies):
        pieces = tuple(
            Solid(f"{k}", meshed(body), pose_from_rpy((0, 0, 0))) for k, body in enumerate(bodies)
        )
        return excess_of(replace(part, mesh=meshed(corner), pieces=pieces))

    legs = [trimesh.creation.box(bounds=[(0, 0, 0), top]) for top in
            ((0.04, 0.01, 0.02), (0.01, 0.04, 0.02))]  # fmt: skip
    assert excess(*legs) < 1e-4
    assert excess(corner.convex_hull) == pytest.approx(0.015, abs=0.0005)


def meshed(body: trimesh.Trimesh) -> Mesh:
    return Mesh(body.vertices, body.faces)


def test_a_file_becomes_a_part_that_is_scanned_saved_and_undone(bench, own):
    bench.do(ImportPart("brick", "brick.stl", box(), is_symmetric=True), "ada")
    state = done(bench)
    made = 'part "brick" is in the cell, 60 x 30 x 20 mm; plans search its grasps'
    assert str(state.message) == made
    brick = state.cell.part("brick")
    assert brick.mass == pytest.approx(0.0432) and brick.symmetry.fold == 2
    assert read_part(own / "parts" / "brick").digest == brick.digest

    bench.do(TakeScan(parts=1, part="brick"), "ada")
    assert done(bench).phase is Phase.SCANNED
    bench.do(SaveCell("a brick too"), "ada")
    saved = bench.wait(lambda state: state.saved == state.cell.digest, PATIENCE)
    assert saved.cell_problem == ""
    assert [part.name for part in read_cell("yumi").parts] == ["keyed_cylinder", "brick"]
    assert part_folders(cell_path("yumi"))["brick"].samefile(own / "parts" / "brick")

    bench.do(UndoCell(), "ada")
    assert [part.name for part in bench.state.cell.parts] == ["keyed_cylinder"]
    bench.do(SaveCell("no brick"), "ada")
    bench.wait(lambda state: state.saved == state.cell.digest, PATIENCE)
    assert [part.name for part in read_cell("yumi").parts] == ["keyed_cylinder"]
    bench.close()
    equal = list(recompute_tasks(Journal(own / "session")))
    assert [one.task for one in equal] == ["scan"] and all(one.says == "equal" for one in equal)


BOMBS = {
    "brick.stl": b"\0" * 80 + b"\xff\xff\xff\xff" + b"\0" * 500,
    "brick.ply": b"ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\n"
    b"property float x\nproperty float y\nproperty float z\nend_header\n",
    "brick.obj": b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 2000000000\n",
    "brick.step": b"ISO-10303-21;\n" + b"(" * 200_000,
}
"""Small files that claim, or would take, more memory than there is."""


@pytest.mark.extensive
def test_a_bomb_fails_and_leaves_nothing(bench, own):
    for number, (file, content) in enumerate(BOMBS.items()):
        bench.do(ImportPart("brick", file, np.frombuffer(content, np.uint8)), "ada")
        state = done(bench)
        assert "failed" in str(state.message) and file in str(state.message)
        assert [part.name for part in state.cell.parts] == ["keyed_cylinder"]
        assert not (own / "parts" / "brick").exists()
        before = state.scan
        bench.do(TakeScan(parts=1, seed=number), "ada")
        state = done(bench)
        assert state.phase is Phase.SCANNED and state.scan is not before, "the worker goes on"


@pytest.mark.parametrize(
    ("changed", "says"),
    [
        ({"name": "../brick"}, "letters, digits"),
        ({"name": "keyed_cylinder"}, "has a part keyed_cylinder already"),
        ({"file": "brick.exe"}, "is no CAD file"),
        ({"content": np.zeros(0, np.uint8)}, "has 0 bytes"),
        ({"unit": "furlong"}, "unit 'furlong' is not known"),
        ({"density": float("nan")}, "density must lie between"),
        ({"density": 1e9}, "density must lie between"),
    ],
)
def test_what_cannot_be_meant_is_refused(idle, changed, says):
    wanted = {"name": "brick", "file": "brick.stl", "content": box(), **changed}
    with pytest.raises(CommandRefused, match=says):
        idle.do(ImportPart(**wanted), "ada")


def test_an_operator_may_not_add_parts(idle):
    with pytest.raises(CommandRefused, match="engineer"):
        idle.do(ImportPart("brick", "brick.stl", box()), "ada", Role.OPERATOR)
