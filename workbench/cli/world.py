"""`workbench export-world`: what was planned, for checking with other tools."""

from collections.abc import Iterator

from workbench.cli import arguments
from workbench.cli.exits import SUCCESS
from workbench.formats.cells import read_cell
from workbench.formats.klampt import PlacedPart, Snapshot, write_world
from workbench.formats.plans import read_plan
from workbench.model.cell import Cell
from workbench.model.errors import InputError
from workbench.model.plan import Plan
from workbench.planning.bodies import part_label
from workbench.planning.legs import phases_of
from workbench.planning.prove import form_findings


def export_world(typed: arguments.ExportWorld) -> int:
    """Write one Klamp't world for the bare cell and one for every leg of a plan."""
    cell = read_cell(typed.cell)
    snapshots = [("cell", Snapshot())]
    if typed.plan is not None:
        plan, _ = read_plan(typed.plan)
        problem = next(form_findings(cell, plan), None)
        if problem is not None:
            raise InputError(f"{typed.plan}: {problem}")
        snapshots += _snapshots(cell, plan)
    for name, snapshot in snapshots:
        print(write_world(typed.out, name, cell, snapshot))
    return SUCCESS


def _snapshots(cell: Cell, plan: Plan) -> Iterator[tuple[str, Snapshot]]:
    """The cell at every leg, named by its number, arm and leg."""
    placed = [
        PlacedPart(part_label(number), cell.part(detection.part), detection.T_world_part)
        for number, detection in enumerate(plan.detections)
    ]
    for number, (arm_plan, leg, phase) in enumerate(phases_of(plan), start=1):
        held = {
            arm: PlacedPart(placed[detection].name, placed[detection].part, T_tcp_part)
            for arm, (detection, T_tcp_part) in phase.held.items()
        }
        away = phase.absent | {detection for detection, _ in phase.held.values()}
        standing = tuple(part for k, part in enumerate(placed) if k not in away)
        yield (
            f"{number:02}-{arm_plan.arm}-{leg.name}",
            Snapshot(standing, phase.openings, held, arm_plan.joints, leg.t, leg.q),
        )
