"""Whether grips that are said to hold a part do, and the others do not: MuJoCo pulls at them."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
import pinocchio as pin
import trimesh

from workbench.formats.cells.reading import read_cell
from workbench.formats.parts.reading import read_part
from workbench.model.cell import Tool
from workbench.model.errors import InputError
from workbench.model.geometry import Floats, spread_directions
from workbench.model.part import Grasp, GraspLibrary, Part
from workbench.model.prediction import TOGETHER
from workbench.perception.simulation.pulling import GripForce, Pulling
from workbench.planning.grasps.firmness import GRAVITY
from workbench.planning.grasps.grasp_check import GraspChecker
from workbench.planning.grasps.grasp_suggestions import suggest
from workbench.planning.grasps.pads import has_pads
from workbench.plugins.progress import Report, silent
from workbench.studies.cases import run_cases

CASES_A_GRIP = 20
"""Cases in a row draw from the same grips."""

MANY = 40
"""Grips that are drawn from, at most."""

FRICTIONS = (0.15, 0.8)
"""No unit: oiled steel to rubber."""

LOADS = (-1.2, 0.1)
"""The load is drawn between powers of ten of what friction holds in line with the grip."""

WAYS = 12
"""Evenly around, in which is pulled beside the direction that is said to be the worst."""


@dataclass(frozen=True, slots=True)
class Case:
    """One grip of one part, by the hand of the first arm of a cell.

    It closes by `force` [N] and accelerates by `acceleration` [m/s2]; the seed draws the grip,
    mass, friction and directions.
    """

    cell: str
    part: str
    seed: int
    force: float = 20.0
    acceleration: float = 5.0


@dataclass(frozen=True, slots=True)
class Pulled:
    """What became of a grip.

    `share` of the load is said to be held, `turns`: it is said to give way by its torque first;
    `stayed`: the part did.
    """

    part: str
    seed: int
    share: float
    turns: bool
    stayed: bool

    @property
    def is_said_to_hold(self) -> bool:
        """Whether it is said to."""
        return self.share >= 1.0


def measure(case: Case, grips: int, *, workers: int = 1, report: Report = silent) -> list[Pulled]:
    """This many grips, the parts in turn; those where the hand pushes the part away are left out.

    Args:
        case: the first one; its part may be several, joined by `TOGETHER`, or empty: all that the
            cell has.
        grips: that are tried.
        workers: processes on this machine.
        report: progress.

    Raises:
        InputError: the first arm's hand takes parts neither by two fingers nor by a cup, or a part
            is not known.
    """
    cell = read_cell(case.cell)
    tool = cell.arms[0].tool
    if not has_pads(tool) and tool.fingers:
        raise InputError(f"cell {cell.name}: the first arm has neither two fingers nor a cup")
    names = case.part.split(TOGETHER) if case.part else [part.name for part in cell.parts]
    for name in names:
        _part(case.cell, name)
    cases = [
        replace(case, part=names[k // CASES_A_GRIP % len(names)], seed=case.seed + k)
        for k in range(grips)
    ]
    results = run_cases(pull_all, cases, workers=workers, report=report)
    return [result for result in results if result is not None]


def pull_all(case: Case) -> Pulled | None:
    """Say of a grip whether it holds, and have it pulled in all directions.

    None where the hand takes the part in no way, or does not hold it as meant even before.
    """
    grasps = _grasps(case.cell, case.part, case.seed // CASES_A_GRIP)
    if not grasps:
        return None
    rng = np.random.default_rng([case.seed, 2])
    grasp = grasps[int(rng.integers(len(grasps)))]
    friction = float(rng.uniform(*FRICTIONS))
    strongest = friction * case.force * 2
    load = strongest * 10.0 ** float(rng.uniform(*LOADS))
    pull = GRAVITY + case.acceleration
    tool = replace(_tool(case.cell), force=case.force)
    part = replace(_part(case.cell, case.part), mass=load / pull, friction=friction)
    checker = GraspChecker(part, tool, case.acceleration)
    said = checker.firmness(grasp.T_part_tcp, grasp.opening)
    if said is None:
        return None
    lip = 0.0 if checker.cup is None else checker.cup.radius
    hand = Pulling(
        part,
        tool,
        grasp.T_part_tcp.inverse(),
        _centre(part),
        GripForce(case.force, friction, lip),
    )
    R = pin.exp3(rng.normal(size=3))
    ways = np.vstack([np.array(said.worst), spread_directions(WAYS) @ R.T])
    stayed = hand.stays(grasp.grip, [pull * way for way in ways])
    if stayed is None:
        return None
    return Pulled(part.name, case.seed, said.share, said.turns, stayed)


def summary(results: Sequence[Pulled]) -> dict[str, Any]:
    """How often what is said and what happens agree, in all, near the limit, and by part.

    False `holds` are grips that are said to hold and did not, false `slips` the other way round.
    """
    near = [result for result in results if 0.5 <= result.share < 2.0]
    names = sorted({result.part for result in results})
    return {
        "all": _row(results),
        "near": _row(near),
        "parts": {
            name: _row([result for result in results if result.part == name]) for name in names
        },
        "false_holds": sorted(
            (round(result.share, 3), result.part, result.seed)
            for result in results
            if result.is_said_to_hold and not result.stayed
        ),
    }


def _row(results: Sequence[Pulled]) -> dict[str, Any]:
    counts = Counter((result.is_said_to_hold, result.stayed) for result in results)
    agree = counts[True, True] + counts[False, False]
    return {
        "grips": len(results),
        "stayed": sum(result.stayed for result in results),
        "agreement": agree / len(results) if results else None,
        "said_to_hold": counts[True, True] + counts[True, False],
        "false_holds": counts[True, False],
        "false_slips": counts[False, True],
    }


def _centre(part: Part) -> Floats:
    """The centre of mass (3,) [m] of a part of one material, by another program than planning's."""
    mesh = trimesh.Trimesh(part.mesh.points, part.mesh.triangles)
    return np.asarray(mesh.center_mass, float)


@lru_cache(maxsize=16)
def _grasps(cell: str, part: str, block: int) -> tuple[Grasp, ...]:
    alone = replace(_part(cell, part), library=GraspLibrary())
    return tuple(
        suggestion.grasp for suggestion in suggest(alone, _tool(cell), most=MANY, seed=block)
    )


@lru_cache(maxsize=4)
def _tool(cell: str) -> Tool:
    return read_cell(cell).arms[0].tool


@lru_cache(maxsize=16)
def _part(cell: str, name: str) -> Part:
    own = {part.name: part for part in read_cell(cell).parts}
    return own[name] if name in own else read_part(name)
