"""Motion problems for an arm of three links in a plane, written by the standard library alone."""

import json
from pathlib import Path
from typing import Any

LINK = 0.4

URDF = """<robot name="{name}">
  <link name="base"/>
  {links}
  <link name="jaw"><collision><geometry><sphere radius="0.03"/></geometry></collision></link>
  {joints}
  <joint name="slide" type="prismatic">
    <parent link="link3"/><child link="jaw"/><origin xyz="0.4 0 0"/><axis xyz="1 0 0"/>
    <limit lower="0" upper="0.05" velocity="0.1" effort="1"/>
  </joint>
</robot>"""

LINK_URDF = """<link name="link{k}"><collision><origin xyz="0.2 0 0" rpy="0 1.5707963 0"/>
  <geometry><cylinder radius="0.03" length="0.4"/></geometry></collision></link>"""

JOINT_URDF = """<joint name="turn{k}" type="revolute">
  <parent link="{parent}"/><child link="link{k}"/><origin xyz="{x} 0 0"/><axis xyz="0 0 1"/>
  <limit lower="-2.5" upper="2.5" velocity="2" effort="1"/></joint>"""

SRDF = """<robot name="{name}">
  <disable_collisions link1="link1" link2="link2" reason="Adjacent"/>
  <disable_collisions link1="link2" link2="link3" reason="Adjacent"/>
  <disable_collisions link1="link3" link2="jaw" reason="Adjacent"/>
</robot>"""

BEHIND = {"name": "behind", "shape": "box", "dimensions": [0.1, 0.1, 0.1], "object_pose": None,
          "pose": {"position": [-2.0, 0, 0], "orientation": [0, 0, 0, 1]}}  # fmt: skip
POST = {"name": "post", "shape": "cylinder", "dimensions": [1.0, 0.08],
        "object_pose": {"position": [0.5, 0, 0], "orientation": [0, 0, 1, 0]},
        "pose": {"position": [-0.3, 0, 0], "orientation": [0, 0, 0, 1]}}  # fmt: skip
BALL = {"name": "ball", "shape": "sphere", "dimensions": [0.1],
        "pose": {"position": [0.9, 0, 0], "orientation": [0, 0, 0, 1]}}  # fmt: skip


def problem(name: str, obstacles: list[dict], goal: tuple[float, ...] = (-1.2, 0.3, 0.2)) -> dict:
    """From one side of the x axis to the other, the jaw a little open."""
    start = (1.2, -0.3, -0.2)
    return {
        "name": name,
        "start": {f"turn{k + 1}": q for k, q in enumerate(start)},
        "goal": {f"turn{k + 1}": q for k, q in enumerate(goal)},
        "others": {"slide": 0.01},
        "obstacles": obstacles,
    }


def make_motion_problems(folder: Path, robot: str = "planar") -> None:
    """A folder for one robot with two sets: one free, one with things in the way."""
    folder.mkdir(parents=True, exist_ok=True)
    links = "".join(LINK_URDF.format(k=k) for k in (1, 2, 3))
    parents = ("base", "link1", "link2")
    joints = "".join(
        JOINT_URDF.format(k=k + 1, parent=parent, x=LINK if k else 0)
        for k, parent in enumerate(parents)
    )
    (folder / f"{robot}.urdf").write_text(URDF.format(name=robot, links=links, joints=joints))
    (folder / f"{robot}.srdf").write_text(SRDF.format(name=robot))
    # At its goal the arm lies straight along the x axis, through the ball.
    touching = problem("into the ball", [BALL], (0.0, 0.0, 0.0))
    beyond = problem("beyond", [BALL], (0.0, 0.0, 2.6))
    sets = {
        "free": [problem("nothing near", [BEHIND])],
        "in_the_way": [problem("past the ball", [BEHIND, BALL]), touching, beyond],
    }
    for name, problems in sets.items():
        write_set(folder / f"{name}.json", robot, name, problems)


def write_set(path: Path, robot: str, name: str, problems: list[Any]) -> None:
    """One file of problems."""
    content = {"format": "motion-problems/1", "robot": robot, "set": name, "problems": problems}
    path.write_text(json.dumps(content))
