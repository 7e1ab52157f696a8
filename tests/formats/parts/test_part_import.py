"""CAD files that become parts, and those that cannot: refused with the reason, nothing left."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mutations import mutated, only_file_errors
from step_files import step_of_prism
from waiting import wait_until

from workbench.formats.meshes.cad_files import read_cad
from workbench.formats.parts.new_part import import_mesh, write_part
from workbench.formats.parts.reading import read_part
from workbench.model.errors import FileError, InputError
from workbench.model.symmetry import Symmetry

BRACKET = [(-20, -12), (20, -12), (20, -6), (-14, -6), (-14, 12), (-20, 12)]


@pytest.fixture(scope="module")
def box() -> trimesh.Trimesh:
    """40 x 30 x 20, in whatever unit it is read."""
    return trimesh.creation.box((40, 30, 20))


@pytest.mark.parametrize("kind", ["stl", "obj", "ply", "glb"])
def test_every_mesh_format_gives_the_same_body(kind, box, tmp_path):
    path = tmp_path / f"box.{kind}"
    surface = box.copy().apply_scale(0.001) if kind == "glb" else box
    surface.export(path)
    imported = import_mesh(path, None if kind == "glb" else "mm")
    assert imported.surface.size == pytest.approx([0.04, 0.03, 0.02], abs=1e-8)
    assert imported.surface.volume == pytest.approx(24e-6, rel=1e-6)
    assert (imported.surface.triangles, imported.surface.components) == (12, 1)
    assert not imported.cad.is_assumed


@pytest.mark.parametrize(("prefix", "scale"), [(".MILLI.", 0.001), ("$", 1.0)])
def test_a_step_file_carries_its_unit(prefix, scale, tmp_path):
    path = tmp_path / "bracket.step"
    outline = [(x * 0.001 / scale, y * 0.001 / scale) for x, y in BRACKET]
    path.write_text(step_of_prism(outline, 0.015 / scale, prefix=prefix))
    imported = import_mesh(path)
    points = imported.mesh.points
    assert points.min(axis=0) == pytest.approx([-0.02, -0.012, 0.0], abs=1e-7)
    assert points.max(axis=0) == pytest.approx([0.02, 0.012, 0.015], abs=1e-7)
    assert imported.surface.volume == pytest.approx((40 * 6 + 6 * 18) * 15e-9, rel=1e-6)
    with pytest.raises(FileError, match="says its unit itself"):
        read_cad(path, "mm")


def test_a_unit_is_assumed_only_when_no_other_is_likely(box, tmp_path):
    path = tmp_path / "box.stl"
    box.export(path)
    cad = read_cad(path)
    assert (cad.unit, cad.is_assumed) == ("mm", True)
    box.copy().apply_scale(0.25).export(path)
    with pytest.raises(FileError, match=r"10 mm in mm, .* 254 mm in inch.*--unit"):
        read_cad(path)
    assert read_cad(path, "inch").mesh.points.max() == pytest.approx(0.127)
    with pytest.raises(FileError, match="unit 'cm' is not one of mm, m, inch"):
        read_cad(path, "cm")
    with pytest.raises(FileError, match=r"would be 1e\+04 mm large"):
        read_cad(path, "m")


def test_a_surface_that_is_open_is_refused_and_mended_on_request(tmp_path):
    ball = trimesh.creation.icosphere(2, 10)
    path = tmp_path / "ball.ply"
    trimesh.Trimesh(ball.vertices, ball.faces[1:], process=False).export(path)
    with pytest.raises(FileError, match="not closed: 3 edges are open; have it mended"):
        import_mesh(path, "mm")
    imported = import_mesh(path, "mm", repair=True)
    assert imported.done == ("holes closed with 1 triangles",)
    half = ball.faces[np.asarray(ball.triangles_center)[:, 2] > 0]
    trimesh.Trimesh(ball.vertices, half, process=False).export(path)
    with pytest.raises(FileError, match="it could not be repaired"):
        import_mesh(path, "mm", repair=True)


def test_a_part_is_written_that_can_be_read(box, tmp_path):
    path = tmp_path / 'a "box".stl'
    box.export(path)
    imported = import_mesh(path, "mm")
    written = write_part(
        tmp_path / "parts",
        "my-box",
        imported,
        mass=0.025,
        symmetry=Symmetry(np.array([1.0, 0, 0]), 2),
        proposal="2-fold",
    )
    part = read_part(written.folder)
    assert part.digest == written.part.digest
    assert (part.name, part.mass, part.symmetry.fold) == ("my-box", 0.025, 2)
    assert part.symmetry.axis.tolist() == [1, 0, 0]
    assert part.library.grasps == ()
    assert np.ptp(part.mesh.points, axis=0) == pytest.approx([0.04, 0.03, 0.02])
    assert sorted(item.name for item in written.folder.iterdir()) == [
        "grasps.toml",
        "my-box.stl",
        "part.toml",
    ]
    assert [item.name for item in (tmp_path / "parts").iterdir()] == ["my-box"]
    assert "2-fold" in (written.folder / "part.toml").read_text()


def test_nothing_is_overwritten_and_names_are_checked(box, tmp_path):
    path = tmp_path / "box.stl"
    box.export(path)
    imported = import_mesh(path, "mm")
    (tmp_path / "there").mkdir()
    with pytest.raises(FileError, match="is there already"):
        write_part(tmp_path, "there", imported, mass=1)
    for name in ("", "../up", "a/b", ".hidden", "x" * 61, "a b"):
        with pytest.raises(InputError, match="letters, digits"):
            write_part(tmp_path, name, imported, mass=1)
    assert sorted(item.name for item in tmp_path.iterdir()) == ["box.stl", "there"]


def test_files_that_are_none_are_refused(tmp_path):
    def refusal(name: str, content: bytes | None) -> str:
        path = tmp_path / name
        if content is not None:
            path.write_bytes(content)
        with pytest.raises(FileError) as refused:
            import_mesh(path, None)
        return str(refused.value)

    assert "no such CAD file" in refusal("gone.stl", None)
    assert "is no CAD file that can be read: one of .stl" in refusal("part.3mf", b"PK\x03\x04")
    assert "holds no triangles" in refusal("empty.stl", b"")
    # 4 thousand million triangles are promised.
    assert "holds no triangles" in refusal(
        "huge.stl", b"\0" * 80 + b"\xff\xff\xff\xff" + b"\0" * 500
    )
    assert "cannot be read" in refusal("garbage.step", bytes(range(256)) * 20)
    assert refusal("cut.step", step_of_prism(BRACKET, 15).encode()[:2000])
    header = "ply\nformat binary_little_endian 1.0\nelement vertex 999999999999\n"
    header += "property float x\nproperty float y\nproperty float z\nend_header\n"
    assert refusal("counts.ply", header.encode())


def _valid(kind: str) -> bytes:
    if kind == "step":
        return step_of_prism(BRACKET, 15).encode()
    content = trimesh.creation.box((0.04, 0.03, 0.02)).export(file_type=kind)
    return content.encode() if isinstance(content, str) else content


@settings(
    max_examples=3,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
@given(st.data())
@pytest.mark.parametrize("kind", ["stl", "obj", "ply", "glb", "step"])
def test_broken_files_are_refused_in_one_line(kind, tmp_path: Path, data):
    content = data.draw(mutated(_valid(kind)))
    unit = None if kind in ("glb", "step") else "m"
    only_file_errors(tmp_path / f"part.{kind}", content, lambda path: import_mesh(path, unit))


SLEEPER = """
import os, pathlib, time

def step_to_glb(*_, **__):
    pathlib.Path(__file__).with_name("began").write_text(str(os.getpid()))
    time.sleep(600)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux ends a process with its parent")
def test_the_reader_ends_with_the_process_that_started_it(tmp_path):
    """A cancelled job is killed; what reads a file for it must not go on alone."""
    (tmp_path / "cascadio.py").write_text(SLEEPER)
    (tmp_path / "a.step").write_text("not read")
    code = "import sys; sys.path.insert(0, sys.argv[1]); from pathlib import Path\n"
    code += "from workbench.formats.meshes.cad_files import read_cad; read_cad(Path(sys.argv[2]))"
    parent = subprocess.Popen([sys.executable, "-c", code, str(tmp_path), str(tmp_path / "a.step")])
    try:
        began = tmp_path / "began"
        wait_until(lambda: began.is_file() and began.read_text())
    finally:
        parent.kill()
        parent.wait()
    assert int(began.read_text()) != parent.pid
    status = Path(f"/proc/{began.read_text()}/status")
    wait_until(lambda: not status.exists() or "State:\tZ" in status.read_text())
