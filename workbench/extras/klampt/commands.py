"""`workbench export-world`: what was planned, for checking with other tools."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from workbench.cli.arguments import top as arguments
from workbench.cli.exits import SUCCESS
from workbench.extras.klampt.robot_writer import write_rob
from workbench.extras.klampt.worlds import Snapshot, WorldPart, robot_with_tools, write_world
from workbench.formats.cells.reading import read_cell
from workbench.formats.plans.plan_files import read_plan
from workbench.model.cell import Cell
from workbench.model.derived.by_tcp import by_plan, from_current_tcp
from workbench.model.errors import InputError
from workbench.model.plan import Plan
from workbench.planning.collision.bodies import part_label
from workbench.planning.collision.legs import stretches
from workbench.planning.kinematics.chain import chain_of
from workbench.proof.claims.form import form_violations


def export_world(typed: arguments.ExportWorld) -> int:
    """Write one Klamp't world for the bare cell, one for every leg of a plan, and the robot."""
    cell = read_cell(typed.cell)
    snapshots = [("cell", Snapshot())]
    if typed.plan is not None:
        plan, _ = read_plan(typed.plan)
        problem = next(form_violations(cell, plan.scene, plan), None)
        if problem is not None:
            raise InputError(f"{typed.plan}: {problem}")
        snapshots += _snapshots(cell, plan)
    for name, snapshot in snapshots:
        print(write_world(typed.out, name, cell, snapshot))
    path = typed.out / "robot.rob"
    write_rob(path, robot_with_tools(cell, Snapshot()))
    print(path)
    return SUCCESS


def _snapshots(cell: Cell, plan: Plan) -> Iterator[tuple[str, Snapshot]]:
    """The cell at every leg, named by its number, arm and leg."""
    if plan.is_tool_plan:
        raise InputError("a plan that changes a tool has no single world: it is not exported")
    by = by_plan(cell, plan)
    placed = [
        WorldPart(part_label(number), cell.part(detection.part), detection.T_world_part)
        for number, detection in enumerate(plan.detections)
    ]
    for number, stretch in enumerate(stretches(plan), start=1):
        phase = stretch.phase
        held = {
            arm: WorldPart(
                placed[detection].name,
                placed[detection].part,
                from_current_tcp(cell.arm(arm).tool, by.arm(arm).tool.tcp) * T_tcp_part,
            )
            for arm, (detection, T_tcp_part) in phase.held.items()
        }
        away = {detection for detection, _ in phase.held.values()}
        put = {
            detection: chain_of(cell, by.arm(arm)).pose(q) * T_tcp_part
            for arm, (detection, T_tcp_part, q) in phase.placed.items()
        }
        parts = tuple(
            replace(part, T=put[k]) if k in put else part
            for k, part in enumerate(placed)
            if k not in away
        )
        names = [f"{arm_plan.arm}-{leg.name}" for arm_plan, leg in stretch.runs]
        t = np.unique(np.concatenate([leg.t for _, leg in stretch.runs]))
        rows = [np.array([leg.at(time) for time in t]) for _, leg in stretch.runs]
        rows += [np.tile(q, (len(t), 1)) for q in stretch.standing.values()]
        arms = [plan.arm for plan, _ in stretch.runs] + list(stretch.standing)
        joints = tuple(joint for arm in arms for joint in cell.arm(arm).joints)
        snapshot = Snapshot(parts, phase.openings, held, joints, t, np.hstack(rows))
        yield f"{number:02}-{'-'.join(names)}", snapshot
