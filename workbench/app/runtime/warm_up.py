"""`python -m workbench.app.runtime.warm_up USE`: compile for one use, tell the share done.

Everything is used once, as it will be.  The process ends when its standard input does, that is
with whoever has started it.
"""

import math
import struct
import sys
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
from numba.core import event

from workbench.app.picking.pipeline import plan_pick
from workbench.app.runtime.compiled_code import Use, is_ready, mark_ready, only_one
from workbench.app.runtime.readiness import end_with_input
from workbench.app.runtime.work import find_parts
from workbench.formats.cells.reading import read_cell
from workbench.formats.clouds.scans import read_cloud
from workbench.formats.meshes.pieces.surfaces import Surface
from workbench.model.geometry import pose_from_rpy
from workbench.perception.bins.floor_search import find_floor
from workbench.perception.localization.eaten import without_background
from workbench.perception.localization.judging import PartSearch
from workbench.perception.localization.localize import begin_search
from workbench.perception.scene.scene_model import scene_model
from workbench.perception.scene.unexplained import unexplained
from workbench.perception.simulation.piles import drop_parts
from workbench.perception.simulation.synthesize import synthesize
from workbench.perception.views.filling import densify
from workbench.planning.collision.distances.measuring import distance
from workbench.planning.collision.motion import halve_curve
from workbench.planning.grasps.grasp_suggestions import suggest
from workbench.planning.grasps.grasp_trial import Trial
from workbench.planning.grasps.part_rays import nearest_points
from workbench.planning.kinematics.chain import chain_of
from workbench.planning.kinematics.execution import compute_times
from workbench.planning.kinematics.inverse import configurations
from workbench.planning.kinematics.upright import UprightLimit, Uprightness
from workbench.planning.planners.ease import ease_corners
from workbench.plugins.planner import planner_named
from workbench.plugins.progress import never, silent
from workbench.proof.claims.timing.jerk import Limits, find_segment_over_jerk_limit


def main(use: Use) -> int:
    """Compile for that use, unless another process has just done so."""
    end_with_input()
    with only_one(use):
        if not is_ready(use):
            event.register("numba:compile", _Teller(COMPILED[use]))
            RUNS[use]()
            mark_ready(use)
    return 0


def see() -> None:
    """Find parts in a scan, and the floor under them."""
    cell = read_cell("yumi")
    scan = synthesize(cell, drop_parts(cell.parts[:1] * 2, cell.bin, seed=28), seed=28)
    find_parts(cell, {"scan": scan, "seed": 0}, silent, never)
    densify(scan.points[::40], 0.001)
    find_floor(scan.points)
    scene = scene_model(scan, cell)
    search = begin_search(scan, cell.parts[0], cell, detail=1.0, scene=scene)
    if isinstance(search, PartSearch):
        without_background(search.depth_map, 1, 0.001)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "scan.pcd"
        file.write_bytes(COMPRESSED)
        read_cloud(file, cell.scanner.T_world_scanner)


def plan() -> None:
    """Look for obstacles in a scan, plan and prove, suggest grasps and try them."""
    cell = read_cell("yumi")
    part = cell.parts[0]
    pile = drop_parts((part, part), cell.bin, seed=28)
    unexplained(cell, synthesize(cell, pile, seed=28), pile)
    plan_pick(cell, pile, "", strategy="both")
    arm, beyond = cell.arms[0], pose_from_rpy((9.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    chain, home = chain_of(cell, arm), np.array(arm.home)
    configurations(chain, beyond, home)
    upright = UprightLimit(chain, np.array([0.0, 0.0, 1.0]), math.pi)
    Uprightness([upright], [len(home)]).find_tilted(np.stack([[home] * 3]))
    zero, far_corner, rng = np.zeros(2), np.ones(2), np.random.default_rng(0)
    planner_named("rrtconnect")(
        zero, far_corner, zero, far_corner, far_corner, lambda a, b: False, iterations=1, rng=rng
    )
    halve_curve(np.zeros((3, 2)))
    ease_corners(np.zeros((3, 2)), lambda a, b: False, far_corner, far_corner, 0.2)
    path = np.array([[0.0, 0.0], [1.0, 0.5], [0.5, 1.0]])
    times = np.diff(compute_times(path, far_corner, far_corner, 0.2, far_corner))
    find_segment_over_jerk_limit(
        np.diff(path, axis=0), times * [1.0, 1.5], Limits(far_corner, far_corner, far_corner), 0.2
    )
    suggest(part, cell.arms[0].tool, most=1, seed=0)
    lying = pose_from_rpy((0.0, 0.0, 0.03), (0.0, math.pi / 2, 0.0))
    trial, grasps = Trial(cell, part), part.grasps[:1]
    nearest_points(part.mesh, np.zeros((1, 3)))
    Surface(part.mesh.points[part.mesh.triangles], spacing=0.001).farthest(np.zeros((1, 3)))
    trial.works([cell.bin.T_world_bin * lying], grasps, trial.usable(grasps))
    hollow = replace(part.mesh, pieces=(part.mesh, part.mesh))
    distance(hollow, lying, hollow, beyond)


COMPRESSED = (
    b"VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 1\nHEIGHT 1\n"
    b"POINTS 1\nDATA binary_compressed\n" + struct.pack("<IIB3f", 13, 12, 11, 0.0, 0.0, 1.0)
)
"""A scan of one point, packed by LZF as it is."""

RUNS: Mapping[Use, Callable[[], None]] = {"seeing": see, "planning": plan}

COMPILED: Mapping[Use, int] = {"seeing": 220, "planning": 270}
"""About how many functions are compiled, those of numba itself included: only for the progress."""


class _Teller(event.Listener):
    """Prints the share done whenever a function was compiled."""

    def __init__(self, expected: int) -> None:
        self._expected = expected
        self._done = 0

    def on_start(self, event: event.Event) -> None:
        """Nothing is done yet."""

    def on_end(self, event: event.Event) -> None:
        """One more is compiled."""
        self._done += 1
        print(min(self._done / self._expected, 0.99), flush=True)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))  # pyright: ignore[reportArgumentType]
