"""Files of others that broke on their way: exit code 2, one sentence, the file and the place."""

import re
import zipfile
from collections.abc import Callable
from pathlib import Path

import made_arm
import pytest
import trimesh
from step_files import step_of_prism

from workbench.cli.main import main

HEAD = '<robot name="made" xmlns:xacro="http://www.ros.org/wiki/xacro">\n'
ARM = made_arm.arm().replace('<robot name="made">', "")
MESH = (
    '<link name="more"><collision><geometry><mesh filename="{}"/></geometry></collision></link>'
    '<joint name="m" type="fixed"><parent link="base"/><child link="more"/></joint></robot>'
)
YAML = '<xacro:property name="p" value="${xacro.load_yaml(\'p.yaml\')}"/>\n'
USED = "<xacro:if value=\"${p['speed'] > 1}\"/>\n"
MODULE = 'MODULE M\n  PROC main()\n    IF TRUE THEN\n      TPWrite "a";\n    ENDIF\n  ENDPROC\n'


@pytest.fixture
def complain(capfd: pytest.CaptureFixture[str], tmp_path: Path) -> Callable[..., str]:
    """The one line that a command says which ends with 2."""

    def typed(*words: object) -> str:
        capfd.readouterr()
        assert main([str(word) for word in words]) == 2
        said = capfd.readouterr().err.strip().splitlines()
        said = [line for line in said if not line.startswith("new cell: ")]
        assert len(said) == 1 and "Traceback" not in said[0], said
        return said[0]

    return typed


ROBOTS = {
    "a mesh that is missing": (
        {"arm.xacro": HEAD + ARM.replace("</robot>", MESH.format("gone.stl"))},
        r"arm.xacro: link 'more', <collision>, <geometry>, <mesh>, line \d+: filename='gone",
    ),
    "a mesh that is missing in a plain URDF": (
        {"arm.xacro": made_arm.arm().replace("</robot>", "\n" + MESH.format("gone.stl"))},
        r"<mesh>, line 19: filename='gone.stl': there is no",
    ),
    "a mesh that an included macro names": (
        {
            "arm.xacro": HEAD
            + '<xacro:include filename="b.xacro"/><xacro:more mesh="gone"/>'
            + ARM.replace("</robot>", MESH.format("gone.stl").partition("</link>")[2]),
            "b.xacro": HEAD
            + "<xacro:macro name='more' params='mesh'>\n"
            + MESH.format("${mesh}.stl").partition("<joint")[0]
            + "</xacro:macro></robot>",
        },
        r"<mesh>, in b.xacro, line 3: filename='gone.stl': there is no",
    ),
    "an include that is missing": (
        {"arm.xacro": HEAD + "\n<xacro:include filename='gone.xacro'/>" + ARM},
        r"arm.xacro: cannot be expanded by xacro, line 3: there is no file \S+gone.xacro",
    ),
    "a macro that calls itself": (
        {
            "arm.xacro": HEAD
            + "<xacro:macro name='m' params='x'>\n<xacro:m x='1'/></xacro:macro>"
            + "<xacro:m x='2'/>"
            + ARM
        },
        r"arm.xacro: cannot be expanded by xacro, line 3: macro 'm' calls itself",
    ),
    "a cyclic include": (
        {
            "arm.xacro": HEAD + '<xacro:include filename="b.xacro"/>' + ARM,
            "b.xacro": HEAD + '<xacro:include filename="arm.xacro"/></robot>',
        },
        r"in \S+b.xacro, line 2: an include leads back to itself \(arm.xacro, b.xacro\)",
    ),
    "wrong yaml": (
        {"arm.xacro": HEAD + YAML + USED + ARM, "p.yaml": "speed: [1, 2\nother: 3\n"},
        r"p.yaml, line 2: is not valid YAML: ",
    ),
    "yaml without a key": (
        {"arm.xacro": HEAD + YAML + USED + ARM, "p.yaml": "other: 3\n"},
        r"arm.xacro: .*line 3: .*no key 'speed'",
    ),
    "half a xacro": (
        {"arm.xacro": (HEAD + ARM)[:900]},
        r"arm.xacro: is not valid XML: .*line \d+",
    ),
    "half an included xacro": (
        {
            "arm.xacro": HEAD + '<xacro:include filename="b.xacro"/>' + ARM,
            "b.xacro": HEAD + '<xacro:macro name="m"',
        },
        r"b.xacro: is not valid XML: .*line 2",
    ),
}


@pytest.mark.parametrize("name", ROBOTS)
def test_a_broken_robot_is_one_sentence_with_its_place(complain, tmp_path, name):
    files, sentence = ROBOTS[name]
    for file, text in files.items():
        made_arm.written(tmp_path / "urdf" / file, text)
    words = ("cell", "new", "x", "--urdf", tmp_path / "urdf" / "arm.xacro")
    assert re.search(sentence, complain(*words, "--out", tmp_path / "cell"))
    assert not (tmp_path / "cell").exists()


@pytest.mark.parametrize("kind", ["stl", "ply", "obj", "glb", "3mf", "dae", "step", "zip"])
def test_half_a_part_is_said_to_be_cut_off(complain, tmp_path, kind):
    whole, half = tmp_path / f"whole.{kind}", tmp_path / f"half.{kind}"
    ball = trimesh.creation.icosphere(2, 10.0)
    if kind == "step":
        whole.write_text(step_of_prism([(0, 0), (20, 0), (20, 10), (0, 10)], 5.0))
    elif kind == "zip":
        with zipfile.ZipFile(whole, "w") as archive:
            archive.writestr("ball.stl", ball.export(file_type="stl"))
    else:
        ball.export(whole)
    half.write_bytes(whole.read_bytes()[: whole.stat().st_size // 2])
    said = complain("part", "import", half, "--name", "ball", "--into", tmp_path / "parts")
    assert f"half.{kind}: " in said and "cut off" in said
    assert not (tmp_path / "parts").exists()


@pytest.mark.parametrize("lines", range(1, 7))
def test_a_module_that_is_cut_off_is_told_with_its_line(complain, tmp_path, lines):
    (tmp_path / "m.mod").write_text("".join(MODULE.splitlines(keepends=True)[:lines]))
    said = complain("rapid", "check", tmp_path / "m.mod")
    assert re.search(r"m\.mod:\d+:\d+: the file ends in the middle: (PROC|MODULE) \w+ has no", said)
