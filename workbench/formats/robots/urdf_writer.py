"""What URDF files consist of: joints and numbers, written as other tools read them."""

import xml.etree.ElementTree as ElementTree
from collections.abc import Iterable
from pathlib import Path

import pinocchio as pin

from workbench.formats.files.whole_files import write_whole
from workbench.model.robot import Joint

EFFORT = 1000.0
"""The standard asks for one; nothing here knows or needs it."""


def write_xml(path: Path, root: ElementTree.Element) -> None:
    """Write an XML file, indented.

    Raises:
        FileError: it cannot be written.
    """
    ElementTree.indent(root)
    write_whole(path, ElementTree.tostring(root, encoding="utf-8", xml_declaration=True) + b"\n")


def numbers(values: Iterable[float]) -> str:
    """Numbers (n,) in the attribute's unit as they are written into it: nothing is lost."""
    return " ".join(repr(float(value)) for value in values)


def joint_element(joint: Joint) -> ElementTree.Element:
    """A joint as URDF has it."""
    element = ElementTree.Element("joint", name=joint.name, type=joint.kind)
    ElementTree.SubElement(element, "parent", link=joint.parent)
    ElementTree.SubElement(element, "child", link=joint.child)
    T = joint.T_parent_joint
    xyz, rpy = numbers(T.translation), numbers(pin.rpy.matrixToRpy(T.rotation))
    ElementTree.SubElement(element, "origin", xyz=xyz, rpy=rpy)
    if joint.kind == "fixed":
        return element
    ElementTree.SubElement(element, "axis", xyz=numbers(joint.axis))
    limits = {"lower": joint.lower, "upper": joint.upper, "velocity": joint.velocity}
    limits["effort"] = EFFORT
    ElementTree.SubElement(element, "limit", {key: repr(float(v)) for key, v in limits.items()})
    return element
