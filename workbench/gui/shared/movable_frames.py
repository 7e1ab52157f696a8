"""What of a cell a person can move: each by name, with its pose, and the cell with another one."""

from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
import pinocchio as pin

from workbench.model.cell import Arm, Cell, Tool
from workbench.model.derived.by_tcp import with_tcp_at
from workbench.model.geometry import Floats, pose_from_rpy
from workbench.model.part import PartPlace, Region
from workbench.planning.kinematics.robot import Kinematics

BIN, SCANNER, ROBOT = "bin", "scanner", "robot"

OF_PARTS = "part-place"
"""Between an arm's name and a number: a place where a part has to lie."""


TCP = "TCP"
"""Before a tool's name: its tool centre point, with an arm that can carry it at home."""


def things(cell: Cell) -> tuple[str, ...]:
    """The names of all that can be moved, as people read them."""
    places = [
        f"{arm.name} place {number}"
        for arm in cell.arms
        for number in range(1, len(arm.Ts_world_place) + 1)
    ]
    places += [
        f"{arm.name} {OF_PARTS} {number}"
        for arm in cell.arms
        for number in range(1, len(arm.part_places) + 1)
    ]
    tcps = [f"{TCP} {name}" for name in _carriers(cell)]
    regions = [name_of_region(region) for region in cell.bin.regions]
    fixtures = [fixture.name for fixture in cell.fixtures]
    # One on an arm is where its arm stands.
    scanner = (SCANNER,) if cell.scanner.on_arm is None else ()
    return (BIN, *regions, *scanner, ROBOT, *fixtures, *places, *tcps)


def frame_of(cell: Cell, thing: str) -> pin.SE3:
    """`T_world_frame` of the frame in which a thing is stated: for a TCP that of its flange."""
    tool = tool_of(cell, thing)
    return _flange(cell, _carriers(cell)[tool].name) if tool else pin.SE3.Identity()


def tool_of(cell: Cell, thing: str) -> str:
    """The tool whose TCP one of `things` is; empty: it is something else."""
    name = thing.removeprefix(f"{TCP} ")
    is_fixture = any(fixture.name == thing for fixture in cell.fixtures)
    return name if name != thing and name in _carriers(cell) and not is_fixture else ""


def _carriers(cell: Cell) -> dict[str, Arm]:
    """The tools of a cell by name, each with the first arm that can carry it."""
    found: dict[str, Arm] = {}
    for arm in cell.arms:
        for tool in (arm.tool, *arm.tools):
            found.setdefault(tool.name, arm)
    return found


@lru_cache(maxsize=8)
def _flange(cell: Cell, arm: str) -> pin.SE3:
    """`T_world_flange` of an arm at home."""
    arm_plan = cell.arm(arm)
    return Kinematics(cell).tcp_pose(arm_plan, arm_plan.home) * arm_plan.tool.T_flange_tcp.inverse()


def _tool(arm: Arm, name: str) -> Tool:
    return next(tool for tool in (arm.tool, *arm.tools) if tool.name == name)


def pose_of(cell: Cell, thing: str) -> pin.SE3:
    """`T_world_thing` of one of `things`."""
    match thing:
        case "bin":
            return cell.bin.T_world_bin
        case "scanner":
            return cell.scanner.T_world_scanner
        case "robot":
            return cell.T_world_robot
        case _:
            for fixture in cell.fixtures:
                if fixture.name == thing:
                    return fixture.T_world_fixture
            for region in cell.bin.regions:
                if name_of_region(region) == thing:
                    return cell.bin.T_world_bin * region.T_bin_region
            if tool := tool_of(cell, thing):
                arm = _carriers(cell)[tool]
                return _flange(cell, arm.name) * _tool(arm, tool).T_flange_tcp
            arm, number = _place(thing)
            if _is_of_parts(thing):
                return cell.arm(arm).part_places[number].T_world_part
            return cell.arm(arm).Ts_world_place[number]


def move_frame(cell: Cell, thing: str, T: pin.SE3) -> Cell:
    """The cell with one of `things` somewhere else."""
    return replace(cell, **moving(cell, thing, T))


def moving(cell: Cell, thing: str, T: pin.SE3) -> dict[str, Any]:
    """The fields of the cell that are others with one of `things` somewhere else.

    Without the cell itself, whose digest takes longer than all that: for while a thing is dragged.
    """
    match thing:
        case "bin":
            return {"bin": replace(cell.bin, T_world_bin=T)}
        case "scanner":
            # Nobody has measured that it hangs there.
            mount = replace(cell.scanner, T_world_scanner=T, calibration=None)
            return {"scanner": mount}
        case "robot":
            return {"T_world_robot": T}
        case _:
            if any(fixture.name == thing for fixture in cell.fixtures):
                fixtures = tuple(
                    replace(fixture, T_world_fixture=T) if fixture.name == thing else fixture
                    for fixture in cell.fixtures
                )
                return {"fixtures": fixtures}
            if any(name_of_region(region) == thing for region in cell.bin.regions):
                T_bin_region = cell.bin.T_world_bin.inverse() * T
                regions = tuple(
                    replace(region, T_bin_region=T_bin_region)
                    if name_of_region(region) == thing
                    else region
                    for region in cell.bin.regions
                )
                return {"bin": replace(cell.bin, regions=regions)}
            if tool := tool_of(cell, thing):
                T_flange_tcp = frame_of(cell, thing).actInv(T)
                return {"arms": _arms_with_tcp(cell, tool, T_flange_tcp)}
            arm, number = _place(thing)
            if _is_of_parts(thing):
                of_parts = _with_pallet(cell.arm(arm).part_places, number, T)
                return {"arms": _arms_with(cell, arm, part_places=of_parts)}
            places = list(cell.arm(arm).Ts_world_place)
            places[number] = T
            return {"arms": _arms_with(cell, arm, Ts_world_place=tuple(places))}


def _with_pallet(places: tuple[PartPlace, ...], number: int, T: pin.SE3) -> tuple[PartPlace, ...]:
    """The places with one somewhere else; those of a pallet in layers go along with it."""
    place = places[number]
    T_new_old = T * place.T_world_part.inverse()
    return tuple(
        replace(other, T_world_part=T)
        if other is place
        else replace(other, T_world_part=T_new_old * other.T_world_part)
        if place.pallet and other.pallet == place.pallet
        else other
        for other in places
    )


def with_places(cell: Cell, arm: str, places: tuple[pin.SE3, ...]) -> Cell:
    """The cell with other places for an arm; a place that stays keeps its name."""
    was = cell.arm(arm)
    known = list(zip(was.Ts_world_place, was.place_names, strict=False))
    names = tuple(next((name for T, name in known if T.isApprox(place)), "") for place in places)
    return _with_arm(cell, arm, Ts_world_place=places, place_names=names if any(names) else ())


def with_home(cell: Cell, arm: str, home: Floats) -> Cell:
    """The cell with another home (n,) [rad] for an arm."""
    return _with_arm(cell, arm, home=home)


def _with_arm(cell: Cell, name: str, **fields: Any) -> Cell:
    return replace(cell, arms=_arms_with(cell, name, **fields))


def _arms_with(cell: Cell, name: str, **fields: Any) -> tuple[Arm, ...]:
    return tuple(replace(arm, **fields) if arm.name == name else arm for arm in cell.arms)


def name_of_region(region: Region) -> str:
    """What a region is called among `things`."""
    return f"region {region.name}"


def _arms_with_tcp(cell: Cell, name: str, T_flange_tcp: pin.SE3) -> tuple[Arm, ...]:
    """All arms with another TCP of a tool, whoever can carry it: it is one table of the file."""

    def change_tool(tool: Tool) -> Tool:
        return with_tcp_at(tool, T_flange_tcp) if tool.name == name else tool

    return tuple(
        replace(arm, tool=change_tool(arm.tool), tools=tuple(map(change_tool, arm.tools)))
        for arm in cell.arms
    )


def _is_of_parts(thing: str) -> bool:
    return thing.split(" ")[1] == OF_PARTS


def _place(thing: str) -> tuple[str, int]:
    arm, _, number = thing.split(" ")
    return arm, int(number) - 1


def typed_pose(position_mm: tuple[float, ...], rpy_deg: tuple[float, ...]) -> pin.SE3:
    """A pose from what a person types, exactly as the cell file reads it."""
    return pose_from_rpy(np.array(position_mm) / 1000, np.deg2rad(rpy_deg))


Three = tuple[float, float, float]

ANGLES = ("roll", "pitch", "yaw")

SAME_TURN = 2e-5
"""[rad] So little two turns differ when their angles are rounded to 0.001 degrees."""


def shown_pose(T: pin.SE3) -> tuple[Three, Three]:
    """Position [mm] and roll, pitch, yaw [deg] of a pose, rounded to what a person would type.

    At a pitch of +-90 degrees, roll and yaw rotate about the same axis: both are shown as yaw.
    """
    rpy = np.rad2deg(pin.rpy.matrixToRpy(T.rotation))
    side = np.copysign(1.0, rpy[1])
    upright = np.array([0.0, side * 90.0, _within(rpy[2] - side * rpy[0])])
    turned = T.actInv(pose_from_rpy(T.translation, np.deg2rad(upright)))
    if np.linalg.norm(pin.log3(turned.rotation)) <= SAME_TURN:
        rpy = upright
    x, y, z = (float(v) for v in np.round(T.translation * 1000, 2) + 0.0)
    roll, pitch, yaw = (_within(float(v)) for v in np.round(rpy, 3) + 0.0)
    return (x, y, z), (roll, pitch, yaw)


def _within(degrees: float) -> float:
    """The same angle above -180 and up to 180 degrees."""
    return degrees if -180.0 < degrees <= 180.0 else 180.0 - (180.0 - degrees) % 360.0
