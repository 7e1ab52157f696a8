"""`workbench part check`: whether a part is fit for picking in a cell, and what it lacks."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from workbench.app.picking.part_import import excess_of
from workbench.app.picking.part_visibility import LEAST_ACROSS, Visibility, visibility
from workbench.app.runtime.readiness import make_ready
from workbench.cli.arguments.part import PartCheck
from workbench.cli.exits import NO_PLAN, SUCCESS
from workbench.cli.terminal import print_json, print_table, progress
from workbench.formats.cells.reading import read_cell
from workbench.formats.meshes.repair import SurfaceReport, examine_surface, joined_corners
from workbench.formats.parts.reading import read_part
from workbench.model.cell import Cell
from workbench.model.derived.by_tcp import is_for, tcp_names, with_tcp
from workbench.model.geometry import Floats, finest
from workbench.model.part import Grasp, Part
from workbench.planning.grasps.coverage import Coverage, coverage
from workbench.planning.grasps.grasp_check import GraspCheck, GraspChecker
from workbench.planning.grasps.part_symmetry import (
    deviation_of,
    tolerance_of,
)
from workbench.planning.kinematics.quickness import hand_acceleration

LEAST_COVERED = 0.5
"""Share of the poses in the bin in which some grasp has to work."""


def check_part(typed: PartCheck) -> int:
    """Print what was found; the exit code is 0 only when nothing speaks against the part."""
    part, cell = read_part(typed.part), read_cell(typed.cell)
    with progress("check") as report:
        make_ready(report, ("planning",))
        report(0.0, "grasps")
        checks = _grasp_checks(part, cell)
        covered = coverage(cell, part, report=lambda done, note: report(0.1 + 0.9 * done, note))
    surface = examine_surface(joined_corners(part.mesh)[0])
    problems = list(_problems(part, cell, surface, checks))
    least = f"{LEAST_COVERED:.0%} are the least"
    if part.library.grasps and covered.share < LEAST_COVERED:
        problems.append(f"grasps work in {covered.share:.0%} of the poses in the bin, {least}")
    lying = covered.lying_share
    if part.library.grasps and lying is not None and lying < LEAST_COVERED:
        problems.append(f"grasps work in {lying:.0%} of the ways to lie on the floor, {least}")
    seen = visibility(cell, part)
    if not seen.is_enough:
        problems.append(
            f"too small for the scanner: {seen.across:.0f} pixels across, {LEAST_ACROSS:.0f} are "
            "the least to find it reliably"
        )
    if typed.json:
        print_json(_form(part, surface, checks, covered, seen, problems))
    else:
        closed = "watertight" if surface.is_watertight else "open"
        print(
            f"part {part.name}: {millimetres(surface.size)} mm, {part.mass * 1000:.4g} g, "
            f"{surface.triangles} triangles, {closed}, {counted_pieces(part)}"
        )
        print(exactness(excess_of(part)))
        if part.library.grasps or not part.library.searches:
            _print_grasps(checks, covered)
            _print_coverage(covered)
        else:
            print("it has no grasps; plans search the grips of the tools")
        print(
            f"seen by the scanner: {seen.pixels} pixels where it lies alone, {seen.across:.0f} "
            f"across, {seen.height * 1000:.1f} mm high"
        )
        for problem in problems:
            print(f"problem: {problem}")
        if not problems:
            print("nothing speaks against this part")
    return SUCCESS if not problems else NO_PLAN


def _problems(
    part: Part, cell: Cell, surface: SurfaceReport, checks: dict[str, list[GraspCheck]]
) -> Iterator[str]:
    """What speaks against a part, one line each."""
    off, allowed = deviation_of(part.mesh, part.symmetry), tolerance_of(part.mesh)
    if off > allowed:
        yield f"symmetry: the stated turns move the surface by {off * 1000:.2f} mm"
    for problem in surface.problems:
        yield f"mesh: {problem}"
    if not part.library.grasps and not part.library.searches:
        yield f"it has no grasps: workbench grasps suggest {part.name} --add"
    for arm, found in checks.items():
        for check in found:
            for finding in check.findings:
                if finding.is_problem:
                    yield f"grasp {check.grasp}, {arm} arm: {finding.text}"
    if part.library.grasps and not any(
        grasp_check.is_ok for found in checks.values() for grasp_check in found
    ):
        yield f"no grasp works with a tool of {cell.name}"


def _form(
    part: Part,
    surface: SurfaceReport,
    checks: dict[str, list[GraspCheck]],
    covered: Coverage,
    seen: Visibility,
    problems: list[str],
) -> dict[str, Any]:
    return {
        "ok": not problems,
        "part": part.name,
        "size_mm": np.round(surface.size * 1000, 3).tolist(),
        "watertight": surface.is_watertight,
        "triangles": surface.triangles,
        "pieces": count_pieces(part),
        "excess_mm": round(excess_of(part) * 1000, 2),
        "grasps": {arm: [_check_form(check) for check in found] for arm, found in checks.items()},
        "coverage": _coverage_form(covered),
        "scanner": {
            "pixels": seen.pixels,
            "across": round(seen.across, 1),
            "height_mm": round(seen.height * 1000, 2),
        },
        "problems": problems,
    }


def _grasp_checks(part: Part, cell: Cell) -> dict[str, list[GraspCheck]]:
    """For each arm that may use them, every grasp's check with its tool."""
    checks: dict[str, list[GraspCheck]] = {}
    for arm in cell.arms:
        acceleration = hand_acceleration(cell, arm)
        tools = [with_tcp(arm.tool, name) for name in tcp_names(arm.tool)]
        checkers = [GraspChecker(part, tool, acceleration) for tool in tools]
        checks[arm.name] = [
            _best_check(checkers, grasp)
            for grasp in part.library.grasps
            if (not grasp.arms or arm.name in grasp.arms)
            and (not grasp.tool or grasp.tool == arm.tool.name)
        ]
    return checks


def _best_check(checkers: list[GraspChecker], grasp: Grasp) -> GraspCheck:
    """The check of a grasp with the first TCP that it is good with, or else with the first one."""
    found = [c.check(grasp) for c in checkers if is_for(grasp, c.tool)] or [
        checkers[0].check(grasp)
    ]
    return next((check for check in found if check.is_ok), found[0])


def _print_grasps(checks: dict[str, list[GraspCheck]], covered: Coverage) -> None:
    good = {
        (arm, check.grasp): _word(check) if check.is_ok else "see below"
        for arm, found in checks.items()
        for check in found
    }
    rows = [
        (
            grasp,
            *(
                f"{good.get((arm, grasp), 'not for it')}, {share:.0%}"
                for arm, share in zip(covered.arms, covered.grasp_shares[g], strict=True)
            ),
        )
        for g, grasp in enumerate(covered.grasps)
    ]
    if rows:
        title = f"Grasps on the part alone, and in which share of {covered.poses} poses in the bin"
        print_table(title, ("grasp", *(f"{arm} arm" for arm in covered.arms)), rows)


def _word(check: GraspCheck) -> str:
    firm = check.firmness
    return "good" if firm is None else f"good, {firm.share:.1f} x the load held"


def _print_coverage(covered: Coverage) -> None:
    each = ", ".join(
        f"{arm} {share:.0%}"
        for arm, share in zip(covered.arms, covered.arm_shares.mean(axis=0), strict=True)
    )
    print(f"covered: {covered.share:.0%} of {covered.poses} poses in the bin ({each})")
    if covered.lying_share is not None:
        print(f"lying on the floor by itself: {covered.lying_share:.0%} of the ways to lie")
    missing = covered.missing
    if missing is None:
        return
    print(
        f"fewest grasps ({missing.share:.0%}) where [{_axis(missing.direction)}] points up: the "
        f"part shows [{millimetres(missing.point)}] mm there, normal [{_axis(missing.normal)}]"
    )
    if missing.suggestion is not None:
        T = missing.suggestion.grasp.T_part_tcp
        print(
            f"to add: the {missing.arm} arm at [{millimetres(T.translation)}] mm along "
            f"[{_axis(T.rotation[:, 2])}] takes {missing.would_work:.0%} of those"
        )


def _coverage_form(covered: Coverage) -> dict[str, Any]:
    missing = covered.missing
    return {
        "poses": covered.poses,
        "share": round(covered.share, 4),
        "lying_share": covered.lying_share and round(covered.lying_share, 4),
        "arms": {
            arm: round(float(share), 4)
            for arm, share in zip(covered.arms, covered.arm_shares.mean(axis=0), strict=True)
        },
        "grasps": {
            grasp: dict(zip(covered.arms, np.round(shares, 4).tolist(), strict=True))
            for grasp, shares in zip(covered.grasps, covered.grasp_shares, strict=True)
        },
        "missing": None
        if missing is None
        else {
            "up": np.round(missing.direction, 4).tolist(),
            "share": round(missing.share, 4),
            "arm": missing.arm,
            "would_work": round(missing.would_work, 4),
        },
    }


def _check_form(check: GraspCheck) -> dict[str, Any]:
    return {
        "grasp": check.grasp,
        "ok": check.is_ok,
        "width_mm": None if check.width is None else round(check.width * 1000, 2),
        "clearance_mm": round(check.clearance * 1000, 2),
        "findings": [str(finding.text) for finding in check.findings],
        **({} if check.firmness is None else {"held_share": round(check.firmness.share, 3)}),
    }


def count_pieces(part: Part) -> int:
    """How many convex pieces stand for a part."""
    return len(finest(part.pieces))


def counted_pieces(part: Part) -> str:
    """The same, in words."""
    return format_count(count_pieces(part), "convex piece")


def exactness(excess: float) -> str:
    """By how much [m] the bodies of a part are too large, in a sentence."""
    return f"The bodies used for distances are at most {excess * 1000:.2f} mm larger than the mesh."


def format_count(count: int, what: str) -> str:
    """How many of something, in words."""
    plural = {"body": "bodies"}.get(what, f"{what}s")
    return f"{count} {what if count == 1 else plural}"


def millimetres(lengths: Floats) -> str:
    """Lengths (n,) [m] for people, four digits each."""
    return ", ".join(f"{value + 0.0:.4g}" for value in np.round(np.asarray(lengths) * 1000, 2))


def _axis(direction: Floats) -> str:
    return ", ".join(f"{value + 0.0:g}" for value in np.round(direction, 2))
