"""How often the checks of a scanner are right: `check_figures.py [touches|trueness] [SEEDS]`.

With `PYTHONPATH=.:tests:tests/perception`, by hand.  Touches: the scanner is calibrated by eight
simulated poses, then an arm touches the three balls of a plate in the bin.
"""

import sys
from dataclasses import replace

import numpy as np
import pinocchio as pin
from held_plates import CENTRES, X, scene

from workbench.app.calibration.simulated_checks import (
    simulated_balls,
    simulated_place,
    touching_joints,
)
from workbench.formats.cells.reading import read_cell
from workbench.model.calibration import SPACING_LIMIT, BallArtefact, BallScan, Touch
from workbench.model.derived.scanner_poses import with_calibrated_scanner
from workbench.perception.calibration.ball_scan import sight_balls
from workbench.perception.calibration.calibrate import calibrate
from workbench.perception.calibration.touch_test import SEATED, assess_touches
from workbench.perception.calibration.trueness import assess_trueness

PLATE = BallArtefact()

SHIFT, TURN = 3e-4, np.deg2rad(0.05)
"""[m, rad] Errors of the robot, along and about each axis of its flange."""

BALL = 5e-5
"""[m] Of a ball's centre along each axis."""

NONE = np.empty(0)


def touches(count: int) -> None:
    """Print a table of the documentation."""
    cell = read_cell("yumi")
    print("| what is off | agrees | common shift named | change named |\n|---|---|---|---|")
    for name, wanted in {
        "scanner as predicted, robot as its residuals": {"is_drawn": True},
        "scanner as calibrated, robot 0.3 mm, 0.05 degrees": {},
        "the same, scanner moved by the prediction": {"times": 1.0},
        "the same, by 2 times the prediction": {"times": 2.0},
        "the same, by 3 times the prediction": {"times": 3.0},
        "the same, TCP off by 3 mm": {"tcp": 3e-3},
    }.items():
        said = [touch_test(cell, seed, **wanted) for seed in range(count)]
        shares = (
            np.mean([word in one for one in said]) for word in (" agree:", "common", "change")
        )
        print(f"| {name} | {' | '.join(f'{share:.0%}' for share in shares)} |")


def touch_test(cell, seed, *, is_drawn=False, times=0.0, tcp=0.0) -> str:
    """What the verdict of one test says."""
    rng = np.random.default_rng(70_000 + seed)
    poses = scene(41_000 + seed, count=8, ball=BALL, shift=SHIFT, turn=TURN, at_flange=True)
    found = calibrate(poses, CENTRES)
    record = found.record(1.0, "ada")
    known = with_calibrated_scanner(cell, found.T_world_scanner, record)
    truth, arm = X, cell.arms[0]
    if is_drawn:
        truth = _moved(
            found.T_world_scanner, rng.multivariate_normal(np.zeros(6), found.covariance)
        )
    place = simulated_place(cell, PLATE, seed)
    centres = [place.act(centre) for centre in PLATE.centres]
    lever = -arm.tool.T_flange_tcp.translation
    made, wrong = [], rng.standard_normal(3)
    for number, centre in enumerate(centres):
        off = np.sqrt(8 / 6 * record.rms**2 / 3) * rng.standard_normal(3)
        if not is_drawn:
            turn = TURN * rng.standard_normal(3)
            off = SHIFT * rng.standard_normal(3) + np.cross(turn, lever)
        off = off + SEATED * rng.standard_normal(3)
        q = touching_joints(cell, arm, centre + off, PLATE.radius, 0.0, seed=10 * seed + number)
        made.append(Touch(f"touch {number + 1}", "scan", arm.name, q))
    if tcp:
        # The cell states a TCP beside the one that has touched.
        T = arm.tool.T_flange_tcp * pin.SE3(np.eye(3), tcp * np.array([1.0, 0.0, 0.0]))
        tool = replace(arm.tool, T_flange_tcp=T)
        known = replace(known, arms=(replace(arm, tool=tool), *known.arms[1:]))

    def test(T_true):
        balls = np.array([T_true.actInv(centre) for centre in centres])
        balls = balls + np.random.default_rng(seed).normal(0, BALL, (3, 3))
        scan = BallScan("scan", PLATE, balls, np.zeros(3), np.zeros(3))
        return assess_touches(known, [scan], made)

    if times:
        far = times * test(truth).allowed.largest
        truth = _moved(truth, np.array([*far * wrong / np.linalg.norm(wrong), 0, 0, 0]))
    return str(test(truth).says)


def _moved(T, move):
    return pin.SE3(pin.exp3(move[3:]) @ T.rotation, T.translation + move[:3])


def trueness(count: int) -> None:
    """Print a table of the documentation."""
    cell = read_cell("yumi")
    lights = {scale: [] for scale in (0.0, 0.001, 0.005)}
    errors = {scale: [] for scale in lights}
    for seed in range(count):
        clouds = [simulated_balls(cell, PLATE, seed=3 * seed + k) for k in range(3)]
        for scale in lights:
            scaled = [replace(cloud, points=cloud.points * (1 + scale)) for cloud in clouds]
            seen = [sight_balls(cloud, PLATE, "scan", NONE, 0) for cloud in scaled]
            found = assess_trueness(seen, SPACING_LIMIT)
            lights[scale].append(found.light)
            errors[scale].append((found.scale, np.abs(found.spacings).max()))
    print("| scale error | true | scale wrong | not true | stated scale error | largest |")
    print("|---|---|---|---|---|---|")
    for scale, said in lights.items():
        shares = [said.count(light) / count for light in ("good", "warning", "bad")]
        stated, largest = np.array(errors[scale]).T
        print(
            f"| {scale:.1%} | {' | '.join(f'{share:.0%}' for share in shares)} "
            f"| {stated.mean():.3%} ± {stated.std():.3%} | {largest.mean() * 1000:.2f} mm |"
        )


if __name__ == "__main__":
    what, seeds = (*sys.argv[1:], *("touches", "100")[len(sys.argv) - 1 :])[:2]
    {"touches": touches, "trueness": trueness}[what](int(seeds))
