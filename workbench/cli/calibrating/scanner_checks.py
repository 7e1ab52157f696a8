"""`workbench scanner trueness` and `touch`: checks of a calibrated scanner."""

from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

from workbench.app.calibration.simulated_checks import (
    simulated_balls,
    simulated_place,
    touching_joints,
)
from workbench.app.core.value_checks import MOST_CHECKS, SEED_LIMIT
from workbench.app.runtime.readiness import make_ready
from workbench.cli.arguments import scanner as arguments
from workbench.cli.exits import NO_PLAN, SUCCESS
from workbench.cli.terminal import check_number, check_whole, print_json, print_table, progress
from workbench.formats.cells.reading import read_cell
from workbench.formats.clouds.scans import read_scan, write_cloud
from workbench.formats.files.whole_files import make_folder
from workbench.formats.poses.joint_rows import read_joint_rows, write_joint_rows
from workbench.model.calibration import BallArtefact, BallScan, Touch
from workbench.model.cell import Cell
from workbench.model.derived.scanner_poses import calibration_covariance
from workbench.model.derived.touches import touch_problem
from workbench.model.errors import InputError
from workbench.model.geometry import Floats
from workbench.perception.calibration.ball_scan import sight_balls
from workbench.perception.calibration.touch_test import SEATED, Offsets, TouchTest, assess_touches
from workbench.perception.calibration.trueness import ADVISED, Trueness, assess_trueness

CLOUDS = (".ply", ".pcd")


def trueness(typed: arguments.ScannerTrueness) -> int:
    """Find the balls in every scan, compare their distances with the stated ones."""
    cell = read_cell(typed.cell)
    check_number("--limit", typed.limit, 0.01, 100)
    artefact = _artefact(typed.ball, typed.lengths)
    if typed.simulate:
        check_whole("--seed", typed.seed, 0, SEED_LIMIT - MOST_CHECKS)
        _simulate_scans(cell, artefact, _one_folder(typed.scans), typed.seed)
    scans: list[BallScan] = []
    missed: list[str] = []
    for path in _clouds(typed.scans):
        try:
            scan = read_scan(path, cell.scanner)
            scans.append(sight_balls(scan, artefact, path.name, _view(cell), 0))
        except InputError as error:
            missed.append(str(error))
    if not scans and missed:
        raise InputError(missed[0])
    found = assess_trueness(scans, typed.limit / 1000)
    if typed.json:
        print_json(_trueness_form(found) | {"not_seen": missed})
    else:
        for problem in missed:
            print(f"left out: {problem}")
        _print_trueness(scans, found)
    return NO_PLAN if found.light == "bad" else SUCCESS


def touch(typed: arguments.ScannerTouch) -> int:
    """Compare where the robot and the scanner have the balls that a tool touches."""
    cell, artefact = read_cell(typed.cell), _artefact(typed.ball, typed.lengths)
    check_number("--limit", typed.limit, 0, 100)
    arm, seat = cell.arm(typed.arm or cell.arms[0].name), typed.tip / 1000
    if typed.simulate:
        _simulate_touches(cell, artefact, typed)
    scan = sight_balls(
        read_scan(typed.scan, cell.scanner), artefact, typed.scan.name, _view(cell), 0
    )
    qs = read_joint_rows(typed.joints, cell, arm)[: MOST_CHECKS + 1]
    check_whole("touches in --joints", len(qs), 0, MOST_CHECKS)
    touches = [Touch(f"touch {k}", scan.name, arm.name, q, seat) for k, q in enumerate(qs, start=1)]
    for each in touches:
        if problem := touch_problem(cell, scan, each):
            raise InputError(f"{each.name}: {problem}")
    found = assess_touches(cell, [scan], touches, typed.limit / 1000 or None)
    if typed.json:
        print_json(_touches_form(found))
    else:
        _print_touches(touches, found)
    return NO_PLAN if found.light == "bad" else SUCCESS


def _trueness_form(found: Trueness) -> dict[str, Any]:
    is_sure = np.isfinite(found.scale_error)
    return {
        "light": found.light,
        "says": str(found.says),
        "sphere_spacing_errors_mm": (found.spacings * 1000).round(4).tolist(),
        "scale_error": round(found.scale, 7),
        "scale_error_99": round(found.scale_error, 7) if is_sure else None,
        "probing_size_error_mm": round(found.size * 1000, 4),
        "probing_form_error_mm": round(found.form * 1000, 4),
    }


def _print_trueness(scans: list[BallScan], found: Trueness) -> None:
    rows = (
        (scan.name, f"{a * 1000:.3f}", f"{b * 1000:.3f}", f"{(b - a) * 1000:+.3f}")
        for scan in scans
        for a, b in zip(scan.artefact.lengths, scan.measured, strict=True)
    )
    print_table("Sphere spacing", ("scan", "stated mm", "measured mm", "error mm"), rows)
    sure = f" ± {found.scale_error:.3%} (99% confidence)" if np.isfinite(found.scale_error) else ""
    print(f"scale error: {found.scale:+.3%}{sure}")
    print(f"probing size error: {found.size * 1000:+.3f} mm in diameter on average")
    print(f"probing form error: {found.form * 1000:.3f} mm (band of 95% of the points)")
    print(found.says)


def _touches_form(found: TouchTest) -> dict[str, Any]:
    return {
        "light": found.light,
        "says": str(found.says),
        "balls": [ball.ball for ball in found.balls],
        "offsets_mm": [(ball.offset * 1000).round(4).tolist() for ball in found.balls],
        "found_mm": _sizes_form(found.found),
        "allowed_mm": _sizes_form(found.allowed),
    }


def _sizes_form(sizes: Offsets) -> dict[str, float]:
    return {
        "largest": round(sizes.largest * 1000, 4),
        "common_shift": round(sizes.shift * 1000, 4),
        "touch_to_touch": round(sizes.rest * 1000, 4),
    }


def _print_touches(touches: list[Touch], found: TouchTest) -> None:
    offsets = [ball.offset * 1000 for ball in found.balls]
    rows = (
        (touch.name, str(ball.ball), f"{np.linalg.norm(off):.2f}", *(f"{v:+.2f}" for v in off))
        for touch, ball, off in zip(touches, found.balls, offsets, strict=True)
    )
    print_table("Scanner less robot", ("touch", "ball", "off mm", "x", "y", "z"), rows)
    found_mm, allowed_mm = _sizes_form(found.found), _sizes_form(found.allowed)
    for key, name in (("common_shift", "common shift"), ("touch_to_touch", "from touch to touch")):
        print(f"{name}: {found_mm[key]:.2f} mm, up to {allowed_mm[key]:.2f} mm expected")
    print(found.says)


def _artefact(ball: float, lengths: tuple[float, ...]) -> BallArtefact:
    """By diameter and distances [mm]."""
    check_number("--ball", ball, 4, 400)
    return BallArtefact(ball / 2000, np.array(lengths) / 1000)


def _view(cell: Cell) -> Floats:
    """Where the arm with the scanner stood: at the view; empty where the scanner stands."""
    carrier = cell.scanner.on_arm
    return np.empty(0) if carrier is None else np.asarray(carrier.view.q)


def _clouds(given: tuple[Path, ...]) -> list[Path]:
    """The files that are given, and all clouds in folders."""
    found: list[Path] = []
    for path in given:
        inside = [p for p in path.iterdir() if p.suffix in CLOUDS] if path.is_dir() else [path]
        found += sorted(inside)
    if not 1 <= len(found) <= MOST_CHECKS:
        raise InputError(f"--scans: 1 to {MOST_CHECKS} clouds are expected, not {len(found)}")
    return found


def _one_folder(given: tuple[Path, ...]) -> Path:
    if len(given) != 1 or given[0].exists():
        raise InputError("--simulate makes a folder: name one that is not there in --scans")
    return given[0]


def _simulate_scans(cell: Cell, artefact: BallArtefact, folder: Path, seed: int) -> None:
    make_folder(folder)
    unit, axes = cell.scanner.unit, cell.scanner.cloud_axes
    for number in range(ADVISED):
        scan = simulated_balls(cell, artefact, seed=seed + number)
        write_cloud(folder / f"place_{number + 1}.ply", scan, unit=unit, axes=axes)


def _simulate_touches(cell: Cell, artefact: BallArtefact, typed: arguments.ScannerTouch) -> None:
    """A scan by a scanner that is off as its calibration predicts, and touches of all balls."""
    check_whole("--seed", typed.seed, 0, SEED_LIMIT - MOST_CHECKS)
    for path in (typed.scan, typed.joints):
        if path.exists():
            raise InputError(f"{path}: is there already; name another file for --simulate")
        make_folder(path.parent)
    rng, arm = np.random.default_rng(typed.seed), cell.arm(typed.arm or cell.arms[0].name)
    T, covariance = cell.scanner.T_world_scanner, calibration_covariance(cell.scanner)
    if covariance is not None:
        off = rng.multivariate_normal(np.zeros(6), covariance)
        T = pin.SE3(pin.exp3(off[3:]) @ T.rotation, T.translation + off[:3])
    with progress("touch") as report:
        make_ready(report, ("planning",))
    scan = simulated_balls(cell, artefact, seed=typed.seed, T_world_scanner=T)
    write_cloud(typed.scan, scan, unit=cell.scanner.unit, axes=cell.scanner.cloud_axes)
    place = simulated_place(cell, artefact, typed.seed)
    qs: list[Floats] = []
    for centre in artefact.centres:
        ball, tip = place.act(centre) + rng.normal(0, SEATED, 3), typed.tip / 1000
        qs.append(touching_joints(cell, arm, ball, artefact.radius, tip, seed=len(qs)))
    write_joint_rows(typed.joints, cell, arm, qs)
