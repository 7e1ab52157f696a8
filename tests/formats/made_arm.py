"""A six-axis arm of boxes in the words of robot makers, and what they add or leave out."""

from pathlib import Path

SOLIDS = (
    ("base", (0.2, 0.2, 0.3), (0, 0, 0.15)),
    ("s1", (0.18, 0.18, 0.12), (0, 0, -0.02)),
    ("s2", (0.1, 0.1, 0.4), (0, 0.08, 0.2)),
    ("s3", (0.22, 0.1, 0.1), (0.07, 0, 0.03)),
    ("s4", (0.2, 0.08, 0.08), (0.12, 0, 0)),
    ("s5", (0.09, 0.07, 0.07), (0.02, 0, 0)),
    ("s6", (0.02, 0.05, 0.05), (-0.01, 0, 0)),
)
JOINTS = (
    ("base", "s1", (0, 0, 0.35), "0 0 1", (-2.97, 2.97)),
    ("s1", "s2", (0.05, 0, 0), "0 1 0", (-1.75, 2.27)),
    ("s2", "s3", (0, 0, 0.4), "0 1 0", (-3.49, 1.22)),
    ("s3", "s4", (0.18, 0, 0.03), "1 0 0", (-3.32, 3.32)),
    ("s4", "s5", (0.24, 0, 0), "0 1 0", (-2.18, 2.18)),
    ("s5", "s6", (0.08, 0, 0), "1 0 0", (-6.28, 6.28)),
)
TOOL0 = """<link name="tool0"/>
<joint name="tool0_mount" type="fixed"><origin rpy="0 1.5707963267948966 0"/>
<parent link="s6"/><child link="tool0"/></joint>
"""
"""z out of the arm, along the last axis."""

XACRO = "http://www.ros.org/wiki/xacro"


def box(sizes: tuple[float, ...], at: tuple[float, ...] = (0, 0, 0)) -> str:
    """What is drawn and checked of a link."""
    one = f'<origin xyz="{_words(at)}"/><geometry><box size="{_words(sizes)}"/></geometry>'
    return f"<visual>{one}</visual><collision>{one}</collision>"


def links(scale: float = 1.0, prefix: str = "") -> str:
    """The links of the arm."""
    return "\n".join(
        f'<link name="{prefix}{name}">{box(_scaled(sizes, scale), _scaled(at, scale))}</link>'
        for name, sizes, at in SOLIDS
    )


def joints(scale: float = 1.0, prefix: str = "") -> str:
    """The joints of the arm, `a1` to `a6`."""
    return "\n".join(
        f'<joint name="{prefix}a{number}" type="revolute">'
        f'<origin xyz="{_words(_scaled(at, scale))}"/>'
        f'<parent link="{prefix}{parent}"/><child link="{prefix}{child}"/><axis xyz="{axis}"/>'
        f'<limit lower="{low}" upper="{high}" velocity="3.5" effort="100"/></joint>'
        for number, (parent, child, at, axis, (low, high)) in enumerate(JOINTS, start=1)
    )


def arm(*, scale: float = 1.0, flange: str = TOOL0, more: str = "") -> str:
    """A URDF of the arm; `flange` and `more` are elements that are added."""
    return f'<robot name="made">\n{links(scale)}\n{joints(scale)}\n{flange}{more}</robot>\n'


def two_arms(torso: str) -> str:
    """Two arms on a torso; `torso` are its joints, `waist` the link that carries both."""
    sides = [
        links(prefix=side) + joints(prefix=side) + _mount(side, y)
        for side, y in (("left_", 0.3), ("right_", -0.3))
    ]
    return (
        f'<robot name="made"><link name="foot"/><link name="waist"/>{torso}{"".join(sides)}</robot>'
    )


def turning(name: str, parent: str, child: str, more: str = "") -> str:
    """A joint that turns about z, as of a torso or a finger."""
    return (
        f'<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/>'
        f'<axis xyz="0 0 1"/><limit lower="-1" upper="2" velocity="1" effort="1"/>{more}</joint>'
    )


def written(path: Path, text: str) -> Path:
    """The text as a file, with the folders above it."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    return path


def package(folder: Path, name: str) -> Path:
    """A package of that name."""
    text = f'<package format="2">\n  <name>{name}</name>\n</package>\n'
    return written(folder / "package.xml", text).parent


def _mount(side: str, y: float) -> str:
    return (
        f'<joint name="{side}mount" type="fixed"><origin xyz="0 {y} 0"/>'
        f'<parent link="waist"/><child link="{side}base"/></joint>'
    )


def _scaled(values: tuple[float, ...], scale: float) -> tuple[float, ...]:
    return tuple(scale * value for value in values)


def _words(values: tuple[float, ...]) -> str:
    return " ".join(f"{value:g}" for value in values)
