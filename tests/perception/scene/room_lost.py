"""How much room boxes around what nobody modelled take away, beside points and columns of points.

    python tests/perception/scene/room_lost.py CELL PARTS SEED COUNT [--above]

Things that the planner is not told of are put beside the parts of a pile; with `--above` these are
such as reach over others.  All grasps are judged five times: without them, with them as they are,
with each 2 mm cube that holds points, with these down to the floor, and with the boxes of today.
"""

import argparse
import time
from collections import defaultdict
from dataclasses import replace
from itertools import product

import numpy as np
import open3d as o3d
import trimesh

from workbench.app.picking.judging import judge
from workbench.formats.cells.reading import read_cell
from workbench.model.candidate import Reason
from workbench.model.cell import Cell, Fixture
from workbench.model.geometry import Box, Cylinder, Solid, pose_from_rpy
from workbench.model.scan import Obstacle
from workbench.perception.scene import unexplained as scene
from workbench.perception.simulation.piles import pile_of
from workbench.perception.simulation.synthesize import synthesize
from workbench.perception.views.surfaces import add_surface, triangles_of

LYING = ("post", "can", "rod leaning", "plate leaning", "bracket", "ring", "cable")
ABOVE = ("bar above", "arch", "sheet")


def box(x, y, z):
    return Box(np.array([x, y, z]))


def shapes_of(kind: str, rng) -> list:
    """Shapes with their poses in the thing's frame, which stands on z = 0."""
    rng.uniform(0, 2 * np.pi)
    at, lying = pose_from_rpy, np.pi / 2
    match kind:
        case "post":
            return [(box(0.02, 0.02, 0.06), at((0, 0, 0.03)))]
        case "can":
            return [(Cylinder(0.015, 0.06), at((0, 0, 0.015), (lying, 0, 0)))]
        case "rod leaning":
            height = 0.06 * np.sin(0.6) + 0.004
            return [(Cylinder(0.004, 0.12), at((0, 0, height), (0, lying - 0.6, 0)))]
        case "plate leaning":
            return [(box(0.08, 0.05, 0.003), at((0, 0, 0.04 * np.sin(0.6) + 0.002), (0, -0.6, 0)))]
        case "bracket":
            long, short = box(0.08, 0.012, 0.012), box(0.012, 0.06, 0.012)
            return [(long, at((0, 0, 0.006))), (short, at((-0.034, 0.036, 0.006)))]
        case "ring":
            turns = [2 * np.pi * k / 12 for k in range(12)]
            piece = box(0.006, 0.0175, 0.006)
            return [
                (piece, at((0.03 * np.cos(a), 0.03 * np.sin(a), 0.003), (0, 0, a))) for a in turns
            ]
        case "cable":
            pieces, a, p = [], rng.uniform(0, 2 * np.pi), np.zeros(2)
            for _ in range(7):
                q = p + 0.022 * np.array([np.cos(a), np.sin(a)])
                middle = (*(p + q) / 2, 0.003)
                pieces.append((Cylinder(0.003, 0.026), at(middle, (0, lying, a))))
                p, a = q, a + rng.uniform(-0.8, 0.8)
            return pieces
        case "bar above":
            return [(Cylinder(0.004, 0.16), at((0, 0, rng.uniform(0.06, 0.12)), (0, lying, 0)))]
        case "arch":
            leg = box(0.012, 0.012, 0.07)
            legs = [(leg, at((x, 0, 0.035))) for x in (-0.05, 0.05)]
            return [*legs, (box(0.112, 0.012, 0.012), at((0, 0, 0.076)))]
        case _:
            return [
                (box(0.05, 0.06, 0.002), at((0.045 * k, 0, 0.05 + 0.008 * s), (0, 0.35 * s, 0)))
                for k, s in ((-1, -1), (0, 1), (1, -1))
            ]


def put(cell: Cell, kind: str, parts, others, farthest: float, rng):
    """Where a thing lies near a part without touching one; None where no place was found."""
    around = o3d.t.geometry.RaycastingScene(nthreads=1)
    for one in parts:
        T = cell.bin.T_world_bin.inverse() * one.T_world_part
        add_surface(around, triangles_of(cell.part(one.part).mesh), T)
    shapes, half = shapes_of(kind, rng), cell.bin.size[:2] / 2
    for _ in range(200):
        x, y = (rng.uniform(-1, 1) * (half[k] - 0.05) for k in range(2))
        T = pose_from_rpy((x, y, 0.0), (0, 0, rng.uniform(0, 2 * np.pi)))
        points = np.vstack([surface(shape, T * T_shape) for shape, T_shape in shapes])
        if np.any(np.abs(points[:, :2]) > half - 0.006):
            continue
        away = around.compute_distance(o3d.core.Tensor(points.astype(np.float32))).numpy().min()
        if any(np.linalg.norm(points[:, None] - o[None], axis=2).min() < 0.015 for o in others):
            continue
        if 0.003 < away < farthest:
            solids = tuple(Solid(f"s{k}", *one) for k, one in enumerate(shapes))
            return Fixture(f"thing{len(others) + 1}", cell.bin.T_world_bin * T, solids), points
    return None


def surface(shape, T):
    is_box = isinstance(shape, Box)
    make = trimesh.creation
    mesh = make.box(shape.size) if is_box else make.cylinder(shape.radius, shape.length)
    return trimesh.sample.sample_surface(mesh, 150, seed=1)[0] @ T.rotation.T + T.translation


def as_boxes(cell: Cell, cells, edge: float) -> tuple[Obstacle, ...]:
    """Exactly these grid cells (n, 3) of the bin's frame, as few boxes that do not overlap."""
    left, boxes = {tuple(c) for c in cells.tolist()}, []
    for low in sorted(left):
        if low not in left:
            continue
        high = [k + 1 for k in low]
        for axis in (2, 1, 0):
            while True:
                spans = [range(low[i], high[i]) for i in range(3)]
                spans[axis] = range(high[axis], high[axis] + 1)
                if not left.issuperset(product(*spans)):
                    break
                high[axis] += 1
        left -= set(product(*(range(low[i], high[i]) for i in range(3))))
        middle, size = (np.array(low) + high) / 2 * edge, (np.array(high) - low) * edge
        boxes.append(Obstacle(cell.bin.T_world_bin * pose_from_rpy(tuple(middle)), size))
    return tuple(boxes)


def columns_of(cells):
    """The grid cells (n, 3), and all below them down to the floor."""
    tops: dict = {}
    for a, b, c in cells.tolist():
        tops[a, b] = max(tops.get((a, b), c), c)
    return np.array([(*at, z) for at, c in tops.items() for z in range(min(0, c), c + 1)])


def seen(cell: Cell, scan, parts):
    """The boxes of today, the cubes (n, 3) that they are around, and how long is their edge [m]."""
    kept, around = [], scene._boxes_around

    def keep(voxels, *rest):
        kept.append(voxels)
        return around(voxels, *rest)

    scene._boxes_around = keep
    try:
        boxes = scene.unexplained(cell, scan, parts)
    finally:
        scene._boxes_around = around
    return boxes, kept[-1].index if boxes else np.zeros((0, 3), int), scene.CUBE


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("cell")
    for name in ("parts", "seed", "count"):
        parser.add_argument(name, type=int)
    parser.add_argument("--above", action="store_true")
    typed = parser.parse_args()
    cell, kinds = read_cell(typed.cell), ABOVE if typed.above else LYING
    counts, scenes = defaultdict(int), 0
    for seed in range(typed.seed, typed.seed + typed.count):
        rng = np.random.default_rng(seed)
        parts = pile_of(cell, cell.parts[0].name, typed.parts, seed=seed)
        things, points = [], []
        for _ in range(2):
            kind = kinds[rng.integers(len(kinds))]
            found = put(cell, kind, parts, points, 0.1 if typed.above else 0.05, rng)
            if found is not None:
                things.append(found[0])
                points.append(found[1])
        truth = replace(cell, fixtures=(*cell.fixtures, *things))
        boxes, cubes, edge = seen(cell, synthesize(truth, parts, seed=seed), parts)
        if not things or not boxes:
            continue
        scenes += 1
        ways = {
            "without them": (cell, ()),
            "as they are": (truth, ()),
            "points": (cell, as_boxes(cell, cubes, edge)),
            "columns": (cell, as_boxes(cell, columns_of(cubes), edge)),
            "boxes": (cell, boxes),
        }
        works = {}
        for way, (among, obstacles) in ways.items():
            began = time.process_time()
            judged = judge(among, parts, obstacles=obstacles, seed=seed)
            counts[way, "ms"] += (time.process_time() - began) * 1000
            # A spare that is not needed is not refused for what stands there.
            works[way] = {
                (one.arm, one.detection, one.grasp.name)
                for one in judged
                if one.verdict.reason in (Reason.OK, Reason.DISABLED)
            }
            counts[way, "work"] += len(works[way])
            counts[way, "parts"] += len({one[1] for one in works[way]})
            counts[way, "solids"] += len(obstacles)
        for way in ways:
            counts[way, "not by boxes"] += len(works[way] - works["boxes"])
            counts[way, "not as they are"] += len(works[way] - works["as they are"])
        print(seed, {way: len(one) for way, one in works.items()}, flush=True)
        print(scenes, "scenes", {f"{way}, {what}": round(n) for (way, what), n in counts.items()})


if __name__ == "__main__":
    main()
