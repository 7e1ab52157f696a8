"""Parts of 20 to 400 mm in cells of their own: the shipped ones are of 24 to 88 mm."""

from pathlib import Path

import trimesh

PARTS = {
    "cube_20": ("tx2_90", (20, 20, 20)),
    "plate_300": ("tx2_90", (300, 120, 10)),
    "bar_400": ("tx2_90", (400, 40, 30)),
    "block_20": ("yumi", (20, 20, 20)),
    "rod_180": ("yumi", (180, 24, 24)),
}
"""The robot that takes each, and its size [mm]."""

CUP = """
[[grasp]]
name = "top"
position_mm = [{x}, 0, {half}]
points_along = [0, 0, -1]
closes_along = [0, 1, 0]
opening_mm = 0
grip_mm = 0
approach_length_mm = 60
free_rotation_deg = 180
"""

FINGERS = """
[[grasp]]
name = "across"
position_mm = [{x}, 0, 0]
points_along = [0, 0, -1]
closes_along = [0, 1, 0]
opening_mm = {open}
grip_mm = {grip}
approach_length_mm = 60

[grasp.pattern]
axis = [1, 0, 0]
angles_deg = [0, 90, 180, 270]
"""

RAIL = """
[[fixture]]
name = "rail"
position_mm = [600, 0, 5]

[[fixture.solid]]
name = "rail"
shape = "box"
size_mm = [330, 12, 60]
position_mm = [0, 85, 30]
"""
"""Beside what lies in the middle of the TX2-90's bin."""


def write_part(folder: Path, name: str) -> Path:
    """A folder with a part: a box, with the grasps that its robot can use."""
    robot, size = PARTS[name]
    made = folder / name
    made.mkdir(parents=True, exist_ok=True)
    trimesh.creation.box(size).export(made / f"{name}.stl")
    (made / "part.toml").write_text(
        f'name = "{name}"\nmass_g = 100\n\n[mesh]\nfile = "{name}.stl"\nunit = "mm"\n\n'
        "[symmetry]\naxis = [0, 0, 1]\nfold = 1\n\n"
        f'[[piece]]\nname = "body"\nshape = "box"\nsize_mm = {list(size)}\n'
    )
    if robot == "tx2_90":
        grasps = CUP.format(x=0, half=size[2] / 2)
    else:
        grasps = FINGERS.format(x=0, open=size[1] + 8, grip=size[1])
    (made / "grasps.toml").write_text(grasps)
    return made


def cell_text(shipped: str, name: str, made: Path) -> str:
    """The text of a shipped cell for another part, and for the TX2-90 with a rail in its bin."""
    robot, _ = PARTS[name]
    known = "puck" if robot == "tx2_90" else "keyed_cylinder"
    text = shipped.replace(f'parts = ["{known}"]', f'parts = ["{made}"]')
    assert text != shipped
    return text + (RAIL if robot == "tx2_90" else "")
