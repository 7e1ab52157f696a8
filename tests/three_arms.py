"""A cell with three arms around a bin, all of balls, cylinders and boxes: written to be read.

Each arm has six axes, a shoulder, an elbow and a wrist, and a suction cup; the bin's middle is the
world's origin, and the arms stand around it in equal angles, facing it.
"""

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np

NAMES = ("north", "south-west", "south_east")

AWAY = 0.55
"""[m] From the middle of the bin to where an arm stands."""

AXES = (
    # axis, where its joint is on the link before [m], limits [deg], length of its link [m]
    ("0 0 1", 0.0, 170, 0.30),
    ("0 1 0", 0.35, 130, 0.29),
    ("0 1 0", 0.35, 150, 0.12),
    ("0 0 1", 0.15, 170, 0.14),
    ("0 1 0", 0.20, 130, 0.04),
    ("0 0 1", 0.06, 180, 0.02),
)

HOME = "[0, -20, 120, 0, 80, 0]"


def write_cell(folder: Path, names: Sequence[str] = NAMES, protocol: str = "abb-socket/2") -> Path:
    """Write the files of the cell with arms of these names, one to three, and give its folder."""
    folder.mkdir(parents=True)
    urdf = "".join(_chain(k) for k in range(len(names)))
    (folder / "arms.urdf").write_text(f'<robot name="arms"><link name="world"/>{urdf}</robot>\n')
    srdf = "".join(_touching(k, name) for k, name in enumerate(names))
    (folder / "arms.srdf").write_text(f'<robot name="arms">{srdf}</robot>\n')
    arms = "".join(_arm(k, name) for k, name in enumerate(names))
    (folder / "cell.toml").write_text(CELL.format(protocol=protocol) + arms)
    return folder


def _base(k: int) -> tuple[np.ndarray, float]:
    """Where an arm stands (2,) [m], and where it faces [rad]."""
    angle = np.deg2rad(90.0 + 120.0 * k)
    return AWAY * np.array([np.cos(angle), np.sin(angle)]), angle + np.pi


def _chain(k: int) -> str:
    """The links and joints of one arm; every link reaches up from its joint."""
    (x, y), facing = _base(k)
    text, parent = "", "world"
    for number, (axis, at, limit, length) in enumerate(AXES, start=1):
        origin = f'xyz="0 0 {at}"'
        if parent == "world":
            origin = f'xyz="{x} {y} {at}" rpy="0 0 {facing}"'
        link, bound = f"link_{k}_{number}", np.deg2rad(limit)
        text += (
            f'<joint name="joint_{k}_{number}" type="revolute"><parent link="{parent}"/>'
            f'<child link="{link}"/><origin {origin}/><axis xyz="{axis}"/>'
            f'<limit lower="{-bound}" upper="{bound}" velocity="3" effort="0"/></joint>'
            f'<link name="{link}"><collision><origin xyz="0 0 {length / 2}"/><geometry>'
            f'<cylinder radius="0.035" length="{length}"/></geometry></collision></link>'
        )
        parent = link
    return text


def _touching(k: int, name: str) -> str:
    """Neighbours, and what the short wrist brings near."""
    links = [*(f"link_{k}_{number}" for number in range(1, 7)), f"{name}_tool"]
    pairs = [*pairwise(links), *zip(links[3:], links[5:], strict=False)]
    return "".join(f'<disable_collisions link1="{a}" link2="{b}"/>' for a, b in pairs)


def _arm(k: int, name: str) -> str:
    base, facing = _base(k)
    aside = facing + np.deg2rad(75.0)
    x, y = 1000 * (base + 0.4 * np.array([np.cos(aside), np.sin(aside)]))
    return f"""
[[arm]]
name = "{name}"
controller_id = "{"ABC"[k]}"
flange = "link_{k}_6"
tool = "cup"
home_deg = {HOME}

[[arm.place]]
position_mm = [{x:.3f}, {y:.3f}, 120]
rpy_deg = [180, 0, 0]
"""


CELL = """
name = "around"
parts = ["puck"]

[robot]
urdf = "arms.urdf"
srdf = "arms.srdf"

[bin]
size_mm = [400, 400, 60]

[scanner]
position_mm = [0, 0, 1200]
rpy_deg = [180, 0, 0]
field_of_view_deg = 30

[controller]
protocol = "{protocol}"

[[tool]]
name = "cup"
press_mm = 3

[tool.tcp]
position_mm = [0, 0, 150]

[[tool.body]]
name = "tube"
shape = "cylinder"
radius_mm = 12
length_mm = 130
position_mm = [0, 0, 85]
"""
