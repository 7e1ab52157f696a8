"""Xacro files as makers publish them, expanded without ROS."""

from pathlib import Path

import made_arm
import pytest

from workbench.formats.robots.descriptions import read_description
from workbench.formats.robots.packages import Packages
from workbench.formats.robots.urdf import read_urdf
from workbench.formats.robots.xacro_files import expand_xacro, is_xacro
from workbench.model.errors import FileError

NAMESPACES = (
    "http://www.ros.org/wiki/xacro",
    "http://ros.org/wiki/xacro",
    "http://wiki.ros.org/xacro",
    "https://ros.org/wiki/xacro",
)
CALLS = '<xacro:include filename="{}"/><xacro:one_link n="base"/>'
MACRO = '<xacro:macro name="one_link" params="n"><link name="${n}"/></xacro:macro>'


def xacro(body: str, namespace: str = made_arm.XACRO) -> str:
    return f'<robot name="made" xmlns:xacro="{namespace}">{body}</robot>'


def link_names(path: Path, **arguments: str) -> list[str]:
    found = read_description(path, arguments=arguments)
    return [link.name for link in found.robot.links]


@pytest.mark.parametrize("namespace", NAMESPACES)
def test_each_namespace_that_makers_write_is_known(tmp_path, namespace):
    path = made_arm.written(
        tmp_path / "a.xacro", xacro(MACRO + '<xacro:one_link n="b"/>', namespace)
    )
    assert is_xacro(path)
    assert link_names(path) == ["b"]


def test_a_urdf_that_only_names_xacro_is_none(tmp_path):
    text = made_arm.arm().replace("<robot", f'<robot xmlns:xacro="{made_arm.XACRO}"')
    path = made_arm.written(
        tmp_path / "a.urdf", text.replace("<link", "<!-- <xacro:x/> -->\n<link", 1)
    )
    assert not is_xacro(path)
    assert len(read_urdf(path).links) == 8


def test_a_package_is_found_above_beside_and_below(tmp_path):
    own = made_arm.package(tmp_path / "repository" / "any_folder", "arm_support")
    beside = made_arm.package(tmp_path / "repository" / "arm_resources", "arm_resources")
    below = made_arm.package(tmp_path / "repository" / "tools" / "deep" / "x", "arm_tools")
    for folder in (own, beside, below):
        made_arm.written(folder / "urdf" / "m.xacro", xacro(MACRO))
    for name in ("arm_support", "arm_resources", "arm_tools"):
        body = CALLS.format(f"$(find {name})/urdf/m.xacro")
        assert link_names(made_arm.written(own / "urdf" / "arm.xacro", xacro(body))) == ["base"]


def test_a_package_elsewhere_is_found_where_a_person_says(tmp_path):
    away = made_arm.package(tmp_path / "there" / "src" / "other", "other")
    made_arm.written(away / "m.xacro", xacro(MACRO))
    file = tmp_path / "here" / "x" / "y" / "z" / "arm.xacro"
    path = made_arm.written(file, xacro(CALLS.format("$(find other)/m.xacro")))
    for folder in (tmp_path / "there", away, away / "..", away.parent):
        assert b'name="base"' in expand_xacro(path, {}, Packages(path, [folder])).content
    with pytest.raises(FileError, match="nowhere: is no folder in which packages could be"):
        Packages(path, [tmp_path / "nowhere"])


def test_a_package_of_a_shell_that_knows_ros_is_found(tmp_path, monkeypatch):
    made_arm.written(tmp_path / "ros" / "share" / "other" / "m.xacro", xacro(MACRO))
    file = tmp_path / "a" / "b" / "c" / "d" / "arm.xacro"
    path = made_arm.written(file, xacro(CALLS.format("$(find other)/m.xacro")))
    monkeypatch.setenv("AMENT_PREFIX_PATH", f"/nowhere:{tmp_path / 'ros'}")
    assert link_names(path) == ["base"]


def test_a_package_that_is_missing_is_named_with_where_it_was_looked_for(tmp_path):
    body = CALLS.format("$(find gone_support)/m.xacro")
    path = made_arm.written(tmp_path / "arm" / "urdf" / "arm.xacro", xacro(body))
    with pytest.raises(FileError, match="package 'gone_support' was not found") as caught:
        link_names(path)
    assert str(tmp_path / "arm") in str(caught.value)
    assert "--package-path" in str(caught.value)


def test_a_robot_does_without_a_missing_package_that_brings_nothing_it_needs(tmp_path):
    control = '<xacro:include filename="$(find gone_control)/urdf/control.xacro"/>'
    path = made_arm.written(tmp_path / "arm.xacro", xacro(control + '<link name="base"/>'))
    found = read_description(path)
    assert [link.name for link in found.robot.links] == ["base"]
    assert any("package 'gone_control' was not found" in note for note in found.notes)


def test_what_a_yaml_file_says_is_taken(tmp_path):
    folder = made_arm.package(tmp_path / "arm", "arm")
    made_arm.written(folder / "config" / "ur5" / "sizes.yaml", "sizes:\n  length: 0.25\n")
    body = """<xacro:arg name="kind" default="none"/>
      <xacro:property name="file" value="$(find arm)/config/$(arg kind)/sizes.yaml"/>
      <xacro:property name="all" value="${xacro.load_yaml(file)}"/>
      <link name="base"><visual><geometry>
      <sphere radius="${all['sizes']['length']}"/></geometry></visual></link>"""
    path = made_arm.written(folder / "urdf" / "arm.xacro", xacro(body))
    (solid,) = read_description(path, arguments={"kind": "ur5"}).robot.link("base").visual
    assert solid.shape.radius == 0.25
    with pytest.raises(FileError, match=r"there is no file .*config/none/sizes\.yaml") as caught:
        link_names(path)
    assert "in config there is ur5" in str(caught.value)
    assert "--xacro kind:=VALUE" in str(caught.value)


def test_an_argument_is_taken_from_below_when_it_is_asked_for_above(tmp_path):
    body = '<xacro:arg name="name" default="b"/><link name="$(arg name)"/>'
    text = xacro(body).replace('name="made"', 'name="$(arg name)"')
    path = made_arm.written(tmp_path / "arm.xacro", text)
    assert link_names(path) == ["b"]
    assert link_names(path, name="c") == ["c"]


@pytest.mark.parametrize(
    ("body", "problem"),
    [
        ("\n<link name='${no_such + 1}'/>", "line 2: name 'no_such' is not defined"),
        ("\n\n<xacro:gone x='1'/>", "line 3: unknown macro name: xacro:gone"),
        (
            "<xacro:macro name='foot' params='size'/>\n<xacro:foot/>",
            r"line 2: Undefined parameters \[size\]",
        ),
        (
            "<link name=\"${xacro.load_yaml('wrong.yaml')}\"/>",
            r"wrong\.yaml, line 2: is not valid YAML: expected",
        ),
        ("<xacro:include filename='again.xacro'/>", r"leads back to itself \(arm\.xacro, again"),
    ],
    ids=["expression", "macro", "parameter", "yaml", "circle"],
)
def test_what_cannot_be_expanded_is_said_with_its_place(tmp_path, body, problem):
    made_arm.written(tmp_path / "wrong.yaml", "a: [1, 2\nb: }\n")
    back = "<xacro:include filename='arm.xacro'/>"
    made_arm.written(tmp_path / "again.xacro", xacro(back))
    path = made_arm.written(tmp_path / "arm.xacro", xacro(body))
    with pytest.raises(FileError, match=problem):
        link_names(path)


def test_an_argument_that_has_no_default_is_asked_for(tmp_path):
    path = made_arm.written(tmp_path / "arm.xacro", xacro('<link name="$(arg who)"/>'))
    with pytest.raises(FileError, match=r"needs the xacro argument 'who': .*--xacro who:=VALUE"):
        link_names(path)


def test_an_argument_that_nobody_asks_for_is_told(tmp_path):
    path = made_arm.written(tmp_path / "arm.xacro", xacro('<link name="${1 + 1}"/>'))
    found = read_description(path, arguments={"ur_typ": "ur5e"})
    assert any("'ur_typ' is not one that this file asks for" in note for note in found.notes)
    plain = made_arm.written(tmp_path / "arm.urdf", made_arm.arm())
    found = read_description(plain, arguments={"ur_type": "ur5e"})
    assert any("takes no arguments" in note for note in found.notes)


def test_a_file_of_macros_says_which_file_calls_them(tmp_path):
    path = made_arm.written(tmp_path / "urdf" / "arm_macro.xacro", xacro(MACRO))
    made_arm.written(tmp_path / "urdf" / "arm.xacro", xacro(CALLS.format("arm_macro.xacro")))
    with pytest.raises(FileError, match="has no links: it only defines 'one_link'") as caught:
        link_names(path)
    assert "take one that includes it: arm.xacro" in str(caught.value)


def test_a_file_without_links_says_so(tmp_path):
    with pytest.raises(FileError, match=r"arm\.urdf: has no links$"):
        link_names(made_arm.written(tmp_path / "arm.urdf", '<robot name="made"/>'))
    with pytest.raises(FileError, match="<include>, <macro> or <property> lack the prefix xacro:"):
        old = '<macro name="x"/><link_of name="${pi}"/>'
        link_names(made_arm.written(tmp_path / "old.xacro", xacro(old)))


@pytest.mark.parametrize(
    ("inner", "problem"),
    [
        ("<robot", "inner.xacro: is not valid XML"),
        (xacro('<xacro:include filename="inner.xacro"/>'), "leads back to itself"),
        (xacro("<link name='${1 / 0}'/>"), "division by zero"),
        (xacro("<xacro:nobody/>"), "unknown macro name: xacro:nobody"),
        (xacro('<xacro:include filename="gone.xacro"/>'), "there is no file .*gone.xacro"),
    ],
)
def test_what_is_wrong_inside_is_named_with_its_file(tmp_path, inner, problem):
    made_arm.written(tmp_path / "inner.xacro", inner)
    body = '<xacro:include filename="inner.xacro"/><link name="base"/>'
    with pytest.raises(FileError, match=problem) as caught:
        link_names(made_arm.written(tmp_path / "arm.xacro", xacro(body)))
    assert str(caught.value).startswith(str(tmp_path / "arm.xacro"))
    assert "\n" not in str(caught.value)


def test_a_xacro_is_not_taken_for_a_urdf_of_a_cell(tmp_path):
    path = made_arm.written(tmp_path / "a.urdf", xacro('<link name="${1}"/>', NAMESPACES[2]))
    with pytest.raises(FileError, match="is a xacro file; `workbench cell new` expands it"):
        read_urdf(path)


def test_an_empty_argument_that_leads_to_no_file_is_named(tmp_path):
    made_arm.written(tmp_path / "arms" / "6dof" / "m.xacro", xacro(MACRO))
    body = (
        '<xacro:arg name="arm" default="arms"/><xacro:arg name="dof" default=""/>'
        + CALLS.format("$(arg arm)/$(arg dof)dof/m.xacro")
    )
    path = made_arm.written(tmp_path / "arm.xacro", xacro(body))
    with pytest.raises(FileError, match=r"argument dof is '': --xacro dof:=VALUE"):
        link_names(path)
    assert link_names(path, dof="6") == ["base"]


def test_a_file_that_lies_elsewhere_in_the_package_is_named_as_the_argument(tmp_path):
    made_arm.written(tmp_path / "package.xml", "<package><name>arms</name></package>")
    there = made_arm.written(tmp_path / "config" / "start.yaml", "links: [base]\n")
    body = (
        '<xacro:arg name="start" default="start.yaml"/>'
        "<link name=\"${xacro.load_yaml('$(arg start)')['links'][0]}\"/>"
    )
    path = made_arm.written(tmp_path / "urdf" / "arm.xacro", xacro(body))
    with pytest.raises(FileError, match="there is no file") as refused:
        link_names(path)
    assert str(refused.value).endswith(f"--xacro start:={there}")
    assert link_names(path, start=str(there)) == ["base"]


def test_a_file_that_is_not_there_is_no_fault_of_an_empty_argument(tmp_path):
    body = '<xacro:arg name="prefix" default=""/>' + CALLS.format("gone.xacro")
    with pytest.raises(FileError, match=r"there is no file .*gone\.xacro") as refused:
        link_names(made_arm.written(tmp_path / "arm.xacro", xacro(body)))
    assert "prefix" not in str(refused.value)
