"""`workbench compile`: what is compiled at its first use otherwise, so that nobody waits for it.

Numba compiles the inner loops of seeing, planning and grasp checks when they are first called,
and keeps them on disk: tens of seconds once on a machine, and after a change of their code.
"""

import time

from workbench.app.runtime.readiness import make_ready
from workbench.cli.arguments.upkeep import Compile
from workbench.cli.exits import FAILURE, SUCCESS
from workbench.cli.terminal import progress


def compile_ahead(typed: Compile) -> int:
    """Compile what is not ready, and tell how long it took."""
    began = time.perf_counter()
    with progress("compile") as report:
        if not make_ready(report):
            return FAILURE
    print(f"compiled what seeing, planning and grasping need; {time.perf_counter() - began:.0f} s")
    return SUCCESS
