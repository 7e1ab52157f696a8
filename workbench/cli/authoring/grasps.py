"""`workbench grasps`: what a part's shape offers to a tool."""

from typing import Any

import numpy as np

from workbench.app.runtime.readiness import make_ready
from workbench.cli.arguments.part import Grasps
from workbench.cli.authoring.fill import fill, grasps_file
from workbench.cli.exits import NO_PLAN, SUCCESS
from workbench.cli.terminal import check_whole, print_json, print_table, progress
from workbench.formats.cells.reading import read_cell
from workbench.formats.parts.grasp_files import add_grasps
from workbench.formats.parts.reading import read_part
from workbench.planning.grasps.grasp_check import GraspCheck
from workbench.planning.grasps.grasp_suggestions import Suggestion, suggest
from workbench.planning.kinematics.quickness import hand_acceleration


def grasps(typed: Grasps) -> int:
    """Print suggestions, and write them into the part's file if that is asked for."""
    check_whole("--most", typed.most, 1, 200)
    check_whole("--seed", typed.seed, 0, 2**32 - 1)
    part, cell = read_part(typed.part), read_cell(typed.cell)
    if typed.fill:
        return fill(typed, part, cell)
    arm = cell.arms[0] if typed.arm is None else cell.arm(typed.arm)
    with progress("grasps") as report:
        make_ready(report, ("planning",))
        report(0.0, "looking at the shape")
        refused: list[GraspCheck] = []
        found = suggest(
            part,
            arm.tool,
            most=typed.most,
            seed=typed.seed,
            acceleration=hand_acceleration(cell, arm),
            refused=refused.append,
        )
    names = [suggestion.grasp.name for suggestion in found]
    file = grasps_file(typed.part)
    if typed.add and found:
        names = list(add_grasps(file, (suggestion.grasp for suggestion in found)))
    if typed.json:
        forms = [_form(name, suggestion) for name, suggestion in zip(names, found, strict=True)]
        added = str(file) if typed.add and found else None
        print_json({"ok": bool(found), "tool": arm.tool.name, "grasps": forms, "added_to": added})
        return SUCCESS if found else NO_PLAN
    if refused:
        firmest = max(refused, key=lambda check: check.findings[0].amount)
        print(f"{len(refused)} left out for the weight; the firmest {firmest.findings[0].text}")
    if not found:
        print(f"{arm.tool.name} of {cell.name} can take {part.name} in no further way")
        return NO_PLAN
    held = () if found[0].check.firmness is None else ("held",)
    print_table(
        f"Grasps of {part.name} for {arm.tool.name}",
        ("grasp", "score", "at mm", "points along", "width mm", "off centre of mass mm", *held),
        [_row(name, suggestion) for name, suggestion in zip(names, found, strict=True)],
    )
    if typed.add:
        print(f"{len(found)} grasps added to {file}")
    return SUCCESS


def _row(name: str, suggestion: Suggestion) -> tuple[str, ...]:
    T = suggestion.grasp.T_part_tcp
    width, firm = suggestion.check.width, suggestion.check.firmness
    return (
        name,
        f"{suggestion.score:.2f}",
        ", ".join(f"{value + 0.0:.1f}" for value in np.round(T.translation * 1000, 1)),
        ", ".join(f"{value + 0.0:.2f}" for value in np.round(T.rotation[:, 2], 2)),
        "" if width is None else f"{width * 1000:.1f}",
        f"{suggestion.lever * 1000:.1f}",
        *(() if firm is None else (f"{firm.share:.1f} x",)),
    )


def _form(name: str, suggestion: Suggestion) -> dict[str, Any]:
    grasp, width, firm = suggestion.grasp, suggestion.check.width, suggestion.check.firmness
    return {
        "name": name,
        "score": round(suggestion.score, 4),
        "position_mm": np.round(grasp.T_part_tcp.translation * 1000, 3).tolist(),
        "points_along": np.round(grasp.T_part_tcp.rotation[:, 2], 6).tolist(),
        "closes_along": np.round(grasp.T_part_tcp.rotation[:, 1], 6).tolist(),
        "opening_mm": round(grasp.opening * 1000, 2),
        "grip_mm": round(grasp.grip * 1000, 2),
        "width_mm": None if width is None else round(width * 1000, 2),
        "clearance_mm": round(suggestion.check.clearance * 1000, 2),
        "lever_mm": round(suggestion.lever * 1000, 2),
        **({} if firm is None else {"held_share": round(firm.share, 3)}),
    }
