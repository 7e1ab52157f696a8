"""`workbench compile`: what is compiled at its first use otherwise, so that nobody waits for it.

Numba compiles the inner loops of seeing, planning and grasp checks when they are first called,
and keeps them on disk: tens of seconds once on a machine, and after a change of their code.
"""

import math
import multiprocessing
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor

from workbench.app.pick import plan_pick
from workbench.app.work import find_parts
from workbench.cli.exits import SUCCESS
from workbench.cli.terminal import progress
from workbench.formats.cells import read_cell
from workbench.model.geometry import pose_from_rpy
from workbench.perception.piles import drop_parts
from workbench.perception.synthesize import synthesize
from workbench.perception.unexplained import unexplained
from workbench.planning.grasp_suggestions import suggest
from workbench.planning.grasp_trial import Trial


def compile_ahead() -> int:
    """See, plan and judge grasps once, in two processes, and tell how long it took."""
    began = time.perf_counter()
    context = multiprocessing.get_context("spawn")
    with progress("compile") as report, ProcessPoolExecutor(2, mp_context=context) as pool:
        tasks = [pool.submit(use) for use in USES]
        for number, (use, task) in enumerate(zip(USES, tasks, strict=True)):
            report(number / len(USES), f"what {use.__name__.strip('_')} needs")
            task.result()
    print(f"compiled what seeing, planning and grasping need; {time.perf_counter() - began:.0f} s")
    return SUCCESS


def _planning() -> None:
    cell = read_cell("yumi")
    pile = drop_parts(cell.parts[:1] * 2, cell.bin, seed=28)
    plan_pick(cell, pile, "", strategy="both")


def _seeing() -> None:
    cell = read_cell("yumi")
    scan = synthesize(cell, drop_parts(cell.parts[:1] * 2, cell.bin, seed=28), seed=28)
    find_parts(cell, {"scan": scan, "seed": 0}, lambda done, note: None, lambda: False)
    unexplained(cell, scan, ())


def _grasping() -> None:
    cell = read_cell("yumi")
    part = cell.parts[0]
    suggest(part, cell.arms[0].tool, most=1, seed=0)
    lying = pose_from_rpy((0.0, 0.0, 0.03), (0.0, math.pi / 2, 0.0))
    trial, grasps = Trial(cell, part), part.grasps[:1]
    trial.works([cell.bin.T_world_bin * lying], grasps, trial.usable(grasps))


USES: tuple[Callable[[], None], ...] = (_planning, _seeing, _grasping)
"""The longest first."""
