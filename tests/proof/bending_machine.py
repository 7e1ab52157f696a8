"""Bends every field of good plans by a seed, proves them, and has the judge look at what holds.

```
PYTHONPATH=.:tests/planning:tests/proof \\
    python tests/proof/bending_machine.py --count 10000 --made FOLDER
```

A bent plan is refused, harmless (the proof holds and the judge finds nothing), or let through (the
proof holds and the judge refuses).  The judge (`judge.py`) shares no code with planning or proof.
The last lines are the table of `docs/proof.md`.
"""

import argparse
import json
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from itertools import islice
from multiprocessing import get_context
from pathlib import Path

import numpy as np
from bend_many import judged_by
from bends import KINDS, OF_PALLETS, opened, other_order, put_elsewhere, shuffled, timed
from bends import turned_in_hand as in_hand
from bent_case import Case, Draw, one_of, small
from bent_cells import PILES, cases, folder_of
from judge import Judge
from judge_files import read

from workbench.app.picking.row import plan_row
from workbench.formats.cells.reading import read_cell
from workbench.model.digest import digest_of
from workbench.model.geometry import pose_from_rpy
from workbench.model.scan import Detection, Scene
from workbench.proof.claims.prove import prove, scene_after

ROOT = Path(__file__).resolve().parents[2]

CELLS = (
    "yumi", "nests", "yumi_full", "regrasp", "tx2_90", "tx2_full", "layers",
    "block_20", "rod_180", "cube_20", "plate_300", "bar_400",
)  # fmt: skip
"""All shipped cells, then parts of 20 to 400 mm."""

OUTCOMES = ("refused", "harmless", "let through")


def taken_elsewhere(case: Case, draw: Draw) -> Case:
    """The hand closes a little beside its grasp; the plan states how it then holds the part."""
    one = one_of(case.plan.arms, draw)
    approach, extract = one.leg("approach"), one.leg("extract")
    off = draw.normal(size=len(one.joints)) * np.deg2rad(small(draw, 0.01, 2))
    ends, begins = np.array(approach.q), np.array(extract.q)
    off = case.cell.controller.motion.rounded(ends[-1] + off) - ends[-1]
    ends[-1] += off
    begins[0] += off
    legs = {
        "approach": replace(approach, q=ends, t=approach.t * 3),
        "extract": replace(extract, q=begins, t=extract.t * 3),
    }
    if draw.random() < 0.7:
        # As far as a turn of the wrist goes that is the same in both frames.
        T = one.T_tcp_part * pose_from_rpy(draw.normal(0, 0.0003, 3), draw.normal(0, 0.005, 3))
        one_bent = replace(one, T_tcp_part=T)
    else:
        one_bent = one
    arms = tuple(
        replace(one_bent, legs=tuple(legs.get(leg.name, leg) for leg in one.legs))
        if arm is one
        else arm
        for arm in case.plan.arms
    )
    return replace(case, plan=replace(case.plan, arms=arms))


def stated_in_hand(case: Case, draw: Draw) -> Case:
    """The part in the hand as far off as one millimetre and one degree."""
    one = one_of(case.plan.arms, draw)
    turn, shift = draw.normal(size=3), draw.normal(size=3)
    turn *= np.deg2rad(draw.uniform(0.01, 1.0)) / np.linalg.norm(turn)
    shift *= draw.uniform(0.0, 0.001) / np.linalg.norm(shift)
    T = one.T_tcp_part * pose_from_rpy(shift, turn)
    arms = tuple(replace(arm, T_tcp_part=T) if arm is one else arm for arm in case.plan.arms)
    return replace(case, plan=replace(case.plan, arms=arms))


def other_station(case: Case, draw: Draw) -> Case:
    """Put on another station, or on none."""
    one = one_of(case.plan.arms, draw)
    names = ["", *(station.name for station in case.cell.stations), "elsewhere"]
    name = one_of([name for name in names if name != one.station], draw)
    arms = tuple(replace(arm, station=name) if arm is one else arm for arm in case.plan.arms)
    return replace(case, plan=replace(case.plan, arms=arms))


def out_of_row(case: Case, draw: Draw) -> Case:
    """What a plan before in the row has left is somewhere else, or the plan does not know of it."""
    boxes = list(case.plan.obstacles)
    parts = list(case.plan.detections)
    moved = [k for k, one in enumerate(parts) if one.T_world_found is not None]
    if moved and draw.random() < 0.6:
        k, size = one_of(moved, draw), small(draw, 0.05, 20)
        way = pose_from_rpy(draw.normal(0, 0.001 * size, 3), draw.normal(0, 0.01 * size, 3))
        parts[k] = replace(parts[k], T_world_part=parts[k].T_world_part * way)
    elif boxes:
        k = int(draw.integers(len(boxes)))
        if draw.random() < 0.5:
            del boxes[k]
        else:
            shift = pose_from_rpy(draw.normal(0, small(draw, 0.0001, 0.05), 3))
            boxes[k] = replace(boxes[k], T_world_box=shift * boxes[k].T_world_box)
    else:
        del parts[int(draw.integers(len(parts)))]
    plan = replace(case.plan, detections=tuple(parts), obstacles=tuple(boxes))
    scene = case.scene
    if draw.random() < 0.3:
        scene = Scene(scene.scan_digest, tuple(parts), tuple(boxes))
    return replace(case, plan=plan, scene=scene)


HARD = (
    stated_in_hand, stated_in_hand, taken_elsewhere, in_hand, opened, put_elsewhere, other_order,
    timed, shuffled, other_station, out_of_row,
)  # fmt: skip
"""Bent as often as all other kinds together."""


def bent_hard(case: Case, draw: Draw) -> tuple[str, Case]:
    """A case with one thing changed, and what that was."""
    pallets = any(one.pallet for arm in case.cell.arms for one in arm.part_places)
    kinds = (*KINDS, *OF_PALLETS) if pallets else KINDS
    kind = one_of(HARD if draw.random() < 0.5 else kinds, draw)
    return kind.__name__, kind(case, draw)


def good_cases(name: str, seed: int, made: Path) -> Iterator[Case]:
    """Good plans of one pile; of `regrasp` both plans of a row over its station."""
    if name != "regrasp":
        yield from cases(name, [seed], made)
        return
    shipped = ROOT / "robots" / "yumi"
    cell, files = (
        read_cell(shipped / "regrasp.toml"),
        read(shipped, ROOT / "parts", "regrasp.toml"),
    )
    draw, floor = np.random.default_rng(seed), cell.bin.T_world_bin.translation
    parts = tuple(
        Detection(
            "keyed_cylinder",
            pose_from_rpy(
                floor + [draw.uniform(-0.05, 0.05), side * draw.uniform(0.05, 0.09), 0.0191],
                (np.pi / 2, 0.0, draw.uniform(0, 2 * np.pi)),
            ),
            0.9,
        )
        for side in (-1, 1)
    )
    scan = digest_of(parts)
    scene = Scene(scan, parts)
    for plan in plan_row(cell, parts, scan, avoided={1: "stays"}, seed=seed).plans:
        yield Case(cell, files, scene, plan)
        scene = scene_after(cell, plan)


def outcome(judge: Judge, case: Case) -> tuple[str, str]:
    """What became of a bent plan, and what the judge says of one that was let through."""
    if not prove(case.cell, case.scene, case.plan).holds:
        return "refused", ""
    refusal = judged_by(judge, case)
    if refusal is None:
        return "harmless", ""
    return "let through", f"{refusal.why}, {refusal.distance * 1e3:.3f} mm, {refusal.legs}"


def bends(name: str, seed: int, made: Path, of_each: int) -> Iterator[dict[str, str | int]]:
    """Bent plans of a cell, pile after pile."""
    while True:
        for plan_number, case in enumerate(good_cases(name, seed, made)):
            judge = Judge()
            for number in range(of_each):
                draw = np.random.default_rng([seed, plan_number, number])
                kind, other = bent_hard(case, draw)
                became, why = outcome(judge, other)
                yield {
                    "cell": name,
                    "seed": seed,
                    "bend": number,
                    "kind": kind,
                    "outcome": became,
                    "why": why,
                }
        seed += 1


def _some(task: tuple[str, int, Path, int]) -> list[dict[str, str | int]]:
    name, seed, made, count = task
    return list(islice(bends(name, seed, made, 50), count))


def table(said: list[dict[str, str | int]], key: str) -> str:
    """Counts of outcomes by kind or cell, in Markdown."""
    rows = [f"| {key} | bent | {' | '.join(OUTCOMES)} |", "|---|" + "---|" * (1 + len(OUTCOMES))]
    for name in [*dict.fromkeys(str(one[key]) for one in said), "all"]:
        of = [one for one in said if name in ("all", one[key])]
        counts = Counter(one["outcome"] for one in of)
        rows.append(f"| `{name}` | {len(of)} | {' | '.join(str(counts[o]) for o in OUTCOMES)} |")
    return "\n".join(rows)


def main() -> None:
    """As the module says."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("cells", nargs="*", help="whose plans are bent, all by default")
    options.add_argument("--count", type=int, default=240, help="of bent plans")
    options.add_argument("--seed", type=int, default=0, help="of the first pile of each cell")
    options.add_argument("--made", type=Path, required=True, help="where cells are made")
    options.add_argument("--out", type=Path, help="a file of all outcomes, JSON lines")
    options.add_argument("--workers", type=int, default=2)
    typed = options.parse_args()
    names = typed.cells or list(CELLS)
    for name in names:
        if name in PILES:
            folder_of(name, typed.made)
    each = -(-typed.count // (10 * len(names)))
    tasks = [
        (name, typed.seed + 1000 * k + 100_000 * CELLS.index(name), typed.made, each)
        for k in range(10)
        for name in names
    ]
    said = []
    with get_context("spawn").Pool(typed.workers) as pool:
        for some in pool.imap(_some, tasks):
            said += some
            if typed.out is not None:
                with typed.out.open("a", encoding="utf-8") as file:
                    file.writelines(json.dumps(one) + "\n" for one in some)
    for one in said:
        if one["outcome"] == "let through":
            print(json.dumps(one))
    print(table(said, "kind"), table(said, "cell"), sep="\n\n")


if __name__ == "__main__":
    main()
