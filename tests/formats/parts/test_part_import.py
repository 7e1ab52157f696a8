"""CAD files that become parts, and those that cannot: refused with the reason, nothing left."""

import subprocess
import sys
import zipfile
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mutations import mutated, only_file_errors
from step_files import step_of_prism
from waiting import wait_until

from workbench.formats.meshes import simplifying
from workbench.formats.meshes.cad_files import SeveralSolids, read_cad
from workbench.formats.meshes.step_files import stated_unit
from workbench.formats.parts import new_part
from workbench.formats.parts.new_part import import_mesh, mass_of, write_part
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
    # Who knows better says so: then it is as large as its numbers are in that unit.
    inches = np.ptp(read_cad(path, "inch").mesh.points, axis=0)
    assert inches == pytest.approx(np.ptp(points, axis=0) * 0.0254 / scale)


@pytest.mark.parametrize(
    ("unit", "metres"),
    [
        ("(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.))", 0.001),
        ("( NAMED_UNIT ( * ) SI_UNIT ( $, .METRE. ) LENGTH_UNIT ( ) )", 1.0),
        ("(CONVERSION_BASED_UNIT('INCH',#9)LENGTH_UNIT()NAMED_UNIT(#8))", 0.0254),
        ("(CONVERSION_BASED_UNIT('DEGREE',#9)NAMED_UNIT(#8)PLANE_ANGLE_UNIT())", 0.001),
    ],
)
def test_the_unit_of_a_step_file_is_read(unit, metres, tmp_path):
    path = tmp_path / "unit.step"
    before = "#5=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.));\n" if "INCH" in unit else ""
    path.write_text(f"ISO-10303-21;\nDATA;\n{before}#7={unit};\nENDSEC;\n")
    assert stated_unit(path) == metres


def test_a_unit_is_assumed_only_when_no_other_is_likely(box, tmp_path):
    path = tmp_path / "box.stl"
    box.export(path)
    cad = read_cad(path)
    assert (cad.unit, cad.is_assumed) == ("mm", True)
    box.copy().apply_scale(0.25).export(path)
    with pytest.raises(
        FileError, match=r"in mm: 10 x 7.5 x 5 mm, .* in inch: 254 x .* kg\): say which"
    ):
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

    assert "there is no such file" in refusal("gone.stl", None)
    assert "is no CAD file that can be read: one of .stl" in refusal("part.igs", b"S")
    assert "holds no triangles" in refusal("empty.stl", b"")
    # 4 thousand million triangles are promised.
    assert "of 4294967295 triangles that it has, 10 are there" in refusal(
        "huge.stl", b"\0" * 80 + b"\xff\xff\xff\xff" + b"\0" * 500
    )
    assert "cannot be read" in refusal("garbage.step", bytes(range(256)) * 20)
    cut = refusal("cut.step", step_of_prism(BRACKET, 15).encode()[:2000])
    assert "is cut off: END-ISO-10303-21 is missing" in cut
    names = (
        "#1=DOCUMENT_FILE('foot.stp','','',#2,'',$);\n#3=DOCUMENT_FILE('arm.stp','','',#2,'',$);\n"
    )
    others = f"ISO-10303-21;\nDATA;\n{names}ENDSEC;\nEND-ISO-10303-21;\n"
    apart = refusal("assembly.stp", others.encode())
    assert "its parts are in other files, import 'foot.stp', 'arm.stp'" in apart
    pointer = b"version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 1\n"
    for name in ("pointer.step", "pointer.stl", "pointer.glb"):
        assert "git lfs pull" in refusal(name, pointer)
    assert "holds no CAD file" in refusal("empty.zip", zipped({}))
    assert "holds 2 CAD files" in refusal("two.zip", zipped({"a.stl": b"", "b.stl": b""}))
    assert "is no zip file that can be read, or is cut off" in refusal(
        "cut.zip", zipped({"a.stl": bytes(500)})[:100]
    )
    assert "needs scene.bin, which is not in the same folder" in refusal(
        "scene.gltf",
        b'{"asset": {"version": "2.0"}, "buffers": [{"uri": "scene.bin", "byteLength": 8}]}',
    )
    header = "ply\nformat binary_little_endian 1.0\nelement vertex 999999999999\n"
    header += "property float x\nproperty float y\nproperty float z\nend_header\n"
    assert refusal("counts.ply", header.encode())


def zipped(files: dict[str, bytes]) -> bytes:
    content = BytesIO()
    with zipfile.ZipFile(content, "w") as archive:
        for name, held in files.items():
            archive.writestr(name, held)
    return content.getvalue()


def assembly(path: Path) -> None:
    """A plate, and two pins that stand on it, turned and moved by nodes within nodes."""
    scene = trimesh.Scene()
    scene.add_geometry(trimesh.creation.box((0.06, 0.04, 0.01)), "plate", "plate")
    turned = trimesh.transformations.rotation_matrix(np.pi / 2, [0, 0, 1])
    scene.graph.update("pins", "world", matrix=turned)
    pin = trimesh.creation.cylinder(0.004, 0.03)
    for k, x in enumerate((-0.01, 0.01)):
        moved = trimesh.transformations.translation_matrix([x, 0, 0.02])
        scene.add_geometry(pin, f"pin{k}", f"pin{k}", parent_node_name="pins", transform=moved)
    scene.export(path)


def test_of_several_solids_one_is_chosen_or_the_whole_never_silently(tmp_path):
    path = tmp_path / "assembly.glb"
    assembly(path)
    with pytest.raises(
        SeveralSolids, match=r"holds 3 solids, pin0 and 1 like it, plate"
    ) as refused:
        import_mesh(path, solid="")
    middles = {one.name: one.placed.points.mean(axis=0).round(6) for one in refused.value.solids}
    assert middles["pin1"].tolist() == pytest.approx([0, 0.01, 0.02], abs=1e-6)
    pin = import_mesh(path, solid="pin1")
    assert pin.surface.size == pytest.approx([0.008, 0.008, 0.03], abs=1e-4)
    assert pin.mesh.points.mean(axis=0) == pytest.approx([0, 0, 0], abs=1e-6)
    whole = import_mesh(path, solid=None)
    assert "3 solids taken as one rigid part" in whole.cad.taken
    assert whole.surface.components == 3 and whole.surface.size[2] == pytest.approx(0.04)
    with pytest.raises(FileError, match="has no solid 'bolt'; there are pin0"):
        import_mesh(path, solid="bolt")


def test_a_zipped_stl_file_is_read(box, tmp_path):
    path = tmp_path / "box.zip"
    path.write_bytes(zipped({"cad/box.stl": box.export(file_type="stl"), "__MACOSX/._b.stl": b""}))
    imported = import_mesh(path, "mm")
    assert imported.surface.volume == pytest.approx(24e-6, rel=1e-6)


@pytest.mark.parametrize("unit", ["inch", "millimeter", "meter"])
def test_a_3mf_file_carries_its_unit(unit, box, tmp_path):
    path = tmp_path / "box.3mf"
    metres = {"inch": 0.0254, "millimeter": 0.001, "meter": 1.0}[unit]
    content = BytesIO(box.copy().apply_scale(0.001 / metres).export(file_type="3mf"))
    with zipfile.ZipFile(content) as archive:
        files = {name: archive.read(name) for name in archive.namelist()}
    files = {
        n: c.replace(b'unit="millimeter"', f'unit="{unit}"'.encode()) for n, c in files.items()
    }
    path.write_bytes(zipped(files))
    assert import_mesh(path).surface.size == pytest.approx([0.04, 0.03, 0.02], rel=1e-5)


def test_a_cube_of_a_metre_is_asked_about_by_its_mass(tmp_path):
    path = tmp_path / "cube.glb"
    trimesh.creation.box((1, 1, 1)).export(path)
    with pytest.raises(FileError, match=r"weigh 1200 kg: give another unit .* or its mass") as told:
        mass_of(import_mesh(path), 1200, None)
    assert told.value.path == str(path)
    assert mass_of(import_mesh(path), 1200, 5.0) == 5.0
    assert import_mesh(path, "inch").surface.size == pytest.approx([0.0254] * 3)


def test_a_part_of_less_than_a_hundredth_of_a_gram_is_asked_about_by_its_mass(tmp_path):
    path = tmp_path / "crumb.stl"
    trimesh.creation.box((1, 1, 1)).export(path)
    with pytest.raises(FileError, match=r"would be 1 x 1 x 1 mm and weigh 0.0012 g: give another"):
        mass_of(import_mesh(path, "mm"), 1200, None)
    assert mass_of(import_mesh(path, "mm"), 1200, 1e-6) == 1e-6


def test_an_open_part_is_taken_as_it_is_when_somebody_says_so(tmp_path):
    ball = trimesh.creation.icosphere(2, 10)
    half = ball.faces[np.asarray(ball.triangles_center)[:, 2] > 0]
    path = tmp_path / "half.ply"
    trimesh.Trimesh(ball.vertices, half, process=False).export(path)
    imported = import_mesh(path, "mm", is_open=True)
    assert imported.surface.problems
    with pytest.raises(FileError, match=r"give it \(--mass-g\)"):
        mass_of(imported, 1200, None)


def test_very_fine_surfaces_are_simplified_and_the_bound_is_told(tmp_path, monkeypatch):
    monkeypatch.setattr(new_part, "LARGE", 2000)
    monkeypatch.setattr(simplifying, "LARGE", 2000)
    path = tmp_path / "ball.stl"
    trimesh.creation.icosphere(5, 25).export(path)
    imported = import_mesh(path, "mm")
    assert imported.done[-1].startswith("simplified from 20480 to ")
    off = float(imported.done[-1].split("at most ")[1].split(" mm")[0]) / 1000
    radii = np.linalg.norm(imported.mesh.points, axis=1)
    assert imported.surface.triangles <= 2000 and imported.surface.is_watertight
    assert np.abs(radii - 0.025).max() <= off + 1e-6


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
    (tmp_path / "a.step").write_text("ISO-10303-21;\nEND-ISO-10303-21;\n")
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


@pytest.mark.parametrize("is_open", [False, True])
def test_a_flat_surface_is_refused_by_its_own_name(tmp_path, is_open):
    sheet = trimesh.Trimesh(
        [(0, 0, 0), (40, 0, 0), (40, 30, 0), (0, 30, 0), (20, 15, 0)],
        [(0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)],
    )
    sheet.export(tmp_path / "sheet.stl")
    with pytest.raises(FileError, match=r"sheet\.stl: is flat: all its points lie in one plane"):
        import_mesh(tmp_path / "sheet.stl", "mm", is_open=is_open)
