"""`workbench cell new`: from a URDF to a cell that can be looked at, checked and changed."""

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from workbench.cli.arguments import top as arguments
from workbench.cli.arguments.cell import CellNew
from workbench.cli.exits import SUCCESS
from workbench.cli.terminal import check_number, check_whole, print_json, print_table, progress
from workbench.formats.cells.writer import write_cell
from workbench.formats.files.shipped import find
from workbench.formats.klampt.robots import read_rob
from workbench.formats.klampt.world_reader import (
    KlamptWorld,
    box_around,
    in_pieces,
    read_klampt_world,
)
from workbench.formats.parts.reading import read_part
from workbench.formats.robots.urdf import read_urdf
from workbench.formats.robots.urdf_package import simplified
from workbench.formats.robots.xacro_files import expanded, is_xacro
from workbench.model.cell import Arm, Cell, Finger, ScannerMount, Tool
from workbench.model.errors import InputError
from workbench.model.geometry import Box, Cylinder, Solid, pose_from_rpy
from workbench.model.part import Bin
from workbench.model.robot import Robot
from workbench.planning.collision.link_pairs import pairs_without_check
from workbench.plugins.robot_link import controller_by, usual_link
from workbench.studies.layout import flanges_of, laid_out, without_hands

DARK, LIGHT = (0.35, 0.36, 0.4), (0.55, 0.57, 0.6)


def new_cell(typed: CellNew) -> int:
    """Make the folder of a cell and tell what was decided."""
    if not re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9_-]{0,59}", typed.name):
        raise InputError(
            f"name {typed.name!r}: letters, digits, - and _ are expected, 1 to 60 of them"
        )
    check_number("--tolerance-mm", typed.tolerance_mm, 0.1, 1000)
    check_whole("--pieces", typed.pieces, 1, 64)
    for value in typed.position_mm:
        check_number("--position-mm", value, -20_000, 20_000)
    folder = Path("robots") / typed.name if typed.out is None else typed.out
    if folder.exists():
        raise InputError(f"{folder}: is there already; choose another name or --out")
    with progress("new cell") as report:
        report(0.0, "reading the robot")
        world = _read(typed)
        robot = world.robot
        flanges = typed.flange or flanges_of(robot)
        robot, gone = without_hands(robot, flanges)
        robot, excess = simplified(
            robot,
            tolerance=typed.tolerance_mm / 1000,
            most=typed.pieces,
            report=lambda done, link: report(0.1 + 0.5 * done, f"convex pieces: {link}"),
        )
        report(0.6, "finding pairs of links that need no check")
        cell = _standing(typed, _bare(typed, robot, flanges), world)
        unchecked = pairs_without_check(cell)
        cell = replace(cell, robot=replace(robot, disabled_pairs=frozenset(unchecked)))
        report(0.7, "looking for a place for the bin")
        cell = laid_out(cell, moves_bin=typed.bin is None)
        path = write_cell(folder, cell, unchecked)
    _tell(typed, path, cell, gone, excess, unchecked)
    return SUCCESS


def import_world(typed: arguments.Import) -> int:
    """Make the folder of a cell from a Klamp't world."""
    return new_cell(
        CellNew(
            re.sub(r"[^A-Za-z0-9_-]", "_", typed.out.name),
            typed.world,
            out=typed.out,
            flange=typed.flange,
            bin=typed.bin,
            tool=typed.tool,
            part=typed.part,
            json=typed.json,
        )
    )


def _read(typed: CellNew) -> KlamptWorld:
    """The robot with its meshes as they are, and what stands around it where the file tells."""
    if typed.urdf.suffix.lower() == ".xml":
        return read_klampt_world(typed.urdf)
    if typed.urdf.suffix.lower() == ".rob":
        robot = read_rob(typed.urdf)
    else:
        arguments: dict[str, str] = {}
        for one in typed.xacro:
            name, sign, value = one.partition(":=")
            if not name or not sign:
                raise InputError(f"--xacro {one!r}: NAME:=VALUE is expected")
            arguments[name] = value
        content = expanded(typed.urdf, arguments) if is_xacro(typed.urdf) else None
        scale = 0.001 if typed.mesh_unit == "mm" else 1.0
        robot = read_urdf(typed.urdf, mesh_scale=scale, content=content)
    T_world_robot = pose_from_rpy(np.array(typed.position_mm) / 1000)
    return KlamptWorld(robot, T_world_robot, np.empty(0), ())


def _standing(typed: CellNew, cell: Cell, world: KlamptWorld) -> Cell:
    """The cell with the still things of a world, one of them its bin if that is said."""
    things = {thing.name: thing for thing in world.things}
    if typed.bin is not None:
        if typed.bin not in things:
            known = ", ".join(things) or "nothing"
            raise InputError(f"--bin {typed.bin!r}: no such thing in the world (there is {known})")
        cell = replace(cell, bin=box_around(things.pop(typed.bin)))
    return replace(
        cell,
        T_world_robot=world.T_world_robot,
        fixtures=tuple(
            in_pieces(thing, tolerance=typed.tolerance_mm / 1000, most=typed.pieces)
            for thing in things.values()
        ),
    )


def _bare(typed: CellNew, robot: Robot, flanges: tuple[str, ...]) -> Cell:
    """A cell with arms and tools; where everything else is comes later."""
    if not 1 <= len(flanges) <= 2:
        raise InputError(
            f"{len(flanges)} flanges are given; one or two are expected: more arms than these are "
            "written into cell.toml by hand"
        )
    for flange in flanges:
        robot.link(flange)
    part = read_part(find("parts", typed.part))
    tool = _suction() if typed.tool == "suction" else _gripper()
    chains = [
        tuple(joint.name for joint in robot.chain(flange) if joint.kind != "fixed")
        for flange in flanges
    ]
    if len(chains) == 2 and set(chains[0]) & set(chains[1]):
        shared = ", ".join(sorted(set(chains[0]) & set(chains[1])))
        raise InputError(
            f"both arms hang on {shared}: arms that share a joint cannot move apart; give one "
            "--flange, or make the joint fixed in the URDF"
        )
    if not typed.flange:
        order = sorted(range(len(flanges)), key=lambda k: "left" in flanges[k])
        flanges, chains = tuple(flanges[k] for k in order), [chains[k] for k in order]
    arms = tuple(
        Arm(
            name=name,
            controller_id=name[0].upper(),
            flange=flange,
            joints=joints,
            axis_order=tuple(range(len(joints))),
            axis_signs=(1,) * len(joints),
            home=_middle(robot, joints),
            acceleration=np.full(len(joints), np.deg2rad(600)),
            tool=tool,
        )
        for name, flange, joints in zip(("right", "left"), flanges, chains, strict=False)
    )
    size = np.array([0.3, 0.4, 0.1]) if typed.tool == "suction" else np.array([0.2, 0.3, 0.05])
    return Cell(
        name=typed.name,
        robot=robot,
        T_world_robot=pose_from_rpy((0, 0, 0)),
        arms=arms,
        bin=Bin(pose_from_rpy((0, 0, 0)), size),
        scanner=ScannerMount(pose_from_rpy((0, 0, 1))),
        controller=controller_by(usual_link()),
        parts=(part,),
    )


def _middle(robot: Robot, joints: tuple[str, ...]) -> Any:
    lower, upper, _ = robot.limits(joints)
    return np.clip(np.zeros(len(joints)), lower, upper)


def _gripper() -> Tool:
    """A parallel gripper of the usual size; its fingers close along y of the TCP."""
    finger = Box(np.array([0.006, 0.01, 0.06]))
    return Tool(
        "gripper",
        pose_from_rpy((0, 0, 0.16), (0, 0, -np.pi / 2)),
        (Solid("palm", Cylinder(0.04, 0.1), pose_from_rpy((0, 0, 0.05)), DARK),),
        tuple(
            Finger(
                Solid(f"finger_{name}", finger, pose_from_rpy((0.003 * side, 0, 0.13)), LIGHT),
                np.array([side, 0.0, 0.0]),
            )
            for name, side in (("a", 1.0), ("b", -1.0))
        ),
        (0.0, 0.06),
    )


def _suction() -> Tool:
    """A suction cup on a tube."""
    return Tool(
        "suction_cup",
        pose_from_rpy((0, 0, 0.2)),
        (
            Solid("mount", Cylinder(0.03, 0.03), pose_from_rpy((0, 0, 0.015)), DARK),
            Solid("tube", Cylinder(0.01, 0.158), pose_from_rpy((0, 0, 0.109)), LIGHT),
            Solid("cup", Cylinder(0.016, 0.012), pose_from_rpy((0, 0, 0.194)), DARK),
        ),
        press=0.003,
    )


def _tell(
    typed: CellNew,
    path: Path,
    cell: Cell,
    gone: tuple[str, ...],
    excess: dict[str, float],
    unchecked: Any,
) -> None:
    if typed.json:
        print_json(
            {
                "file": str(path),
                "arms": [{"arm": arm.name, "flange": arm.flange} for arm in cell.arms],
                "left_out": list(gone),
                "excess_mm": {link: round(e * 1000, 1) for link, e in excess.items()},
                "unchecked": [[*pair, reason] for pair, reason in sorted(unchecked.items())],
            }
        )
        return
    counts = {link.name: len(link.collision) for link in cell.robot.links}
    print_table(
        "What is checked in place of the meshes",
        ("link", "convex pieces", "larger than the mesh by at most mm"),
        [(link, str(counts[link]), f"{e * 1000:.1f}") for link, e in excess.items()],
    )
    print_table(
        "Pairs of links that are not checked",
        ("link", "link", "why"),
        [(*pair, reason) for pair, reason in sorted(unchecked.items())],
    )
    for arm in cell.arms:
        print(f"{arm.name} arm: {len(arm.joints)} joints to {arm.flange}, tool {arm.tool.name}")
    if gone:
        print(f"left out, as they hang on a flange: {', '.join(gone)}")
    print(f"{path}: written; look at it, then: workbench cell check {path.parent}")
