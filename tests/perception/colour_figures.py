"""How kinds and turns are told by colour: `colour_figures.py [SCENES] [FIRST]`.

With `PYTHONPATH=.:tests/perception`.  Eight parts lie in each scene, in a light drawn from the
seed; they are searched without using the colours and with them.
"""

import sys
from dataclasses import replace

import numpy as np
from painted_parts import BLACK, BLUE, GREY, RED, WHITE, cube, rod

from workbench.formats.cells.reading import read_cell
from workbench.model.part import Part
from workbench.model.scan import Detection
from workbench.perception.simulation.colouring import Light
from workbench.perception.simulation.piles import drop_parts
from workbench.perception.simulation.synthesize import synthesize
from workbench.plugins.localizer import find_parts

COUNT = 8
NEAR = 0.005
"""[m] A part found is the one whose middle is nearest, if it is no further away."""

CASES: dict[str, tuple[Part, ...]] = {
    "red and blue rods": (rod(RED, RED, "red"), rod(BLUE, BLUE, "blue")),
    "white and black rods": (rod(WHITE, WHITE, "white"), rod(BLACK, BLACK, "black")),
    "rods with one half red": (rod(RED, GREY),),
    "cubes with one face blue": (cube(BLUE),),
}


def drawn_light(seed: int) -> Light:
    """A light up to 20 % warmer or colder, half to four thirds as bright, and a noisy camera."""
    draw = np.random.default_rng((seed, 7))
    red, blue = draw.uniform(-0.2, 0.2, 2)
    gains = np.exp(np.array([red, 0.0, blue]) + draw.uniform(-0.7, 0.3))
    return Light(gains, ambient=draw.uniform(0.2, 0.6), noise=draw.uniform(0.003, 0.015))


def is_right(one: Detection, truth: tuple[Detection, ...], kinds: tuple[Part, ...]) -> bool:
    """Whether kind, or the end that is painted, is that of the part which lies there."""
    middle = kinds[0].mesh.middle
    off = [np.linalg.norm(t.T_world_part.act(middle) - one.T_world_part.act(middle)) for t in truth]
    true = truth[int(np.argmin(off))]
    if min(off) > NEAR:
        return False
    up, truly = (each.T_world_part.rotation[:, 2] for each in (one, true))
    return one.part == true.part if len(kinds) > 1 else bool(up @ truly > 0.98)


def main(scenes: int = 8, first: int = 92001) -> None:
    """Print a row for each case: parts, and of those found how many are right."""
    print("| parts | lie there | by shape, right | with colours, right | told by colour, right |")
    print("|---|---|---|---|---|")
    for name, kinds in CASES.items():
        cell = replace(read_cell("yumi"), parts=kinds)
        plain = replace(cell, parts=tuple(replace(kind, colours=None) for kind in kinds))
        counts = np.zeros(7, int)
        for seed in range(first, first + scenes):
            truth = drop_parts(kinds * (COUNT // len(kinds)), cell.bin, seed=seed)
            scan = synthesize(cell, truth, seed=seed, light=drawn_light(seed))
            shape, colour = (find_parts(scan, each, seed=0).detections for each in (plain, cell))
            told = tuple(one for one in colour if one.by_colour)
            counts[0] += len(truth)
            for k, found in enumerate((shape, colour, told)):
                right = sum(is_right(one, truth, kinds) for one in found)
                counts[1 + 2 * k : 3 + 2 * k] += len(found), right
        lie, *rest = counts.tolist()
        pairs = [f"{right} of {found}" for found, right in zip(rest[::2], rest[1::2], strict=True)]
        print(f"| {name} | {lie} | {' | '.join(pairs)} |", flush=True)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
