"""`workbench cell check`: whether a cell can work, before anything is scanned."""

from collections import Counter
from collections.abc import Iterator, Sequence

import numpy as np

from workbench.app.picking.pallets import pallet_problems, pallets_of
from workbench.app.picking.stations import station_problems
from workbench.app.runtime.readiness import make_ready
from workbench.app.standing.in_view import base_places
from workbench.cli.arguments.cell import CellCheck
from workbench.cli.authoring.pose import round_axes
from workbench.cli.exits import NO_PLAN, SUCCESS
from workbench.cli.terminal import print_json, print_table, progress
from workbench.formats.cells.reading import read_cell
from workbench.model.cell import Arm, Cell
from workbench.model.load import Load, tool_load
from workbench.model.scan import Detection
from workbench.planning.empty_hand.tool_change import slot_problem
from workbench.planning.placing.chance import CONFIDENCE
from workbench.planning.placing.sources import calibration_error
from workbench.studies.layout.flange_picture import draw_flanges
from workbench.studies.layout.flanges import lean_of
from workbench.studies.reach import PlacedPart, Reach, reach_of
from workbench.studies.targets import Target

SLOW = np.deg2rad(1.0)
"""[rad/s] A joint that turns no faster has probably a limit that was never filled in."""

NO_SPEED = 100.0
"""[rad/s] A joint that turns faster has probably no limit."""

SURELY = 1.96
"""Deviations within which a normal error is in `CONFIDENCE` of all cases."""

SKEW = np.deg2rad(5.0)
"""[rad] A flange whose z is further off the last axis than this holds no tool as one expects."""


def check_cell(typed: CellCheck) -> int:
    """Print what was found; the exit code is 0 only when nothing speaks against the cell."""
    cell = read_cell(typed.cell)
    if typed.picture is not None:
        draw_flanges(typed.picture, cell)
    reaches: list[Reach] = []
    with progress("check") as report:
        make_ready(report, ("planning",))
        for number, arm in enumerate(cell.arms):
            report(number / len(cell.arms), f"{arm.name} arm")
            reaches.append(reach_of(cell, arm))
    problems = [
        problem
        for arm, reach in zip(cell.arms, reaches, strict=True)
        for problem in _problems(cell, arm, reach)
    ]
    problems += _slot_problems(cell)
    problems += map(str, station_problems(cell))
    problems += map(str, pallet_problems(cell))
    problems += _unseen_bases(cell)
    loads = [(arm, tool_load(arm.tool)) for arm in cell.arms]
    notes = list(_notes(cell))
    if typed.json:
        print_json(
            {
                "ok": not problems,
                "cell": cell.name,
                "digest": cell.digest,
                "arms": [_form(reach) for reach in reaches],
                "loads": [_load_form(arm, load) for arm, load in loads],
                "problems": problems,
                "notes": notes,
            }
        )
        return SUCCESS if not problems else NO_PLAN
    print(f"cell {cell.name}, digest {cell.digest[:12]}, parts: {_names(cell)}")
    for arm in cell.arms:
        counted = "as the controller counts them"
        if arm.mapping is not None:
            counted = "before axis_coupling and axis_offsets"
        print_table(
            f"{arm.name} arm: axes {counted}",
            ("axis", "joint", "lower deg", "upper deg", "speed deg/s", "home deg"),
            _axes(cell, arm),
        )
        if arm.mapping is not None:
            shown = ", ".join(f"{value:g}" for value in round_axes(cell, arm, arm.home))
            print(f"home as the controller shows it: {shown}")
    print_table(
        "Reach: tool straight down over a grid in the bin, and the places",
        ("arm", "poses in the bin", "clear", "in collision", "out of reach", "places reached"),
        [_words(reach) for reach in reaches],
    )
    for pallet in pallets_of(cell, ()):
        print(f"{pallet.arm} pallet {pallet.number}: {pallet.places} places in layers")
    for arm, load in loads:
        if load is not None:
            print(f"{arm.name} arm, load of {arm.tool.name}: {load.words}")
            moments = ", ".join(f"{value:.3g}" for value in np.diag(load.inertia))
            print(f"  its inertia about that, along the axes of the flange: {moments} kg m2")
    for note in notes:
        print(f"note: {note}")
    for problem in problems:
        print(f"problem: {problem}")
    if not problems:
        print("nothing speaks against this cell")
    return SUCCESS if not problems else NO_PLAN


def _notes(cell: Cell) -> Iterator[str]:
    """What the cell does not say of loads, and what its robot link does not prove."""
    for name, tool in {arm.tool.name: arm.tool for arm in cell.arms}.items():
        if tool.mass is None:
            yield (
                f"mass_g of {name} is missing, so the controller gets no load and its collision "
                "detection may stop the robot; write it into [[tool]]"
            )
            continue
        keys = {"centre_of_gravity_mm": tool.centre_of_gravity, "inertia_kgm2": tool.inertia}
        missing = [key for key, value in keys.items() if value is None]
        if missing:
            yield f"{' and '.join(missing)} of {name} estimated from its bodies"
    if cell.controller.motion.sends_poses:
        yield (
            f"vision only: the robot link {cell.controller.link} sends poses, and nothing of the "
            "robot's motion is proven; the robot's program has to keep clear of everything"
        )
    yield from _narrow_joints(cell)
    for place in base_places(cell):
        if 0 < len(place.seen_from) < place.views:
            yield (
                f"recipe {place.recipe}: {place.base} at place {place.place} of the {place.arm} "
                f"arm is only viewed from {' and '.join(place.seen_from)}"
            )
    if not cell.controller.motion.takes_loads:
        yield f"the robot link {cell.controller.link} sends no load; set it on the controller"


def _unseen_bases(cell: Cell) -> Iterator[str]:
    """Bases that a scan has to show at places which no view of the scanner shows."""
    for place in base_places(cell):
        if not place.seen_from:
            yield (
                f"recipe {place.recipe}: look_again needs {place.base} in the scan, and place "
                f"{place.place} of the {place.arm} arm is in no view of the scanner"
            )


def _narrow_joints(cell: Cell) -> Iterator[str]:
    """Joints of assemblies that take less than the calibration is off."""
    for recipe in cell.recipes:
        for item in recipe.items:
            if item.insertion is None or item.insertion.joint is None:
                continue
            lies = Detection(item.part, cell.bin.T_world_bin)
            off = calibration_error(cell.scanner, lies)[:3, :3]
            far = SURELY * float(np.sqrt(np.linalg.eigvalsh(off)[-1]))
            if far > item.insertion.joint.takes:
                yield (
                    f"recipe {recipe.number}: the joint of {item.part} and {item.insertion.base} "
                    f"takes {item.insertion.joint.takes * 1000:.2g} mm, and the calibration alone "
                    f"is off by {far * 1000:.2g} mm in the bin ({CONFIDENCE:.0%}, along one axis)"
                )


def _load_form(arm: Arm, load: Load | None) -> dict[str, object]:
    if load is None:
        return {"arm": arm.name, "tool": arm.tool.name, "mass_g": None}
    return {
        "arm": arm.name,
        "tool": arm.tool.name,
        "mass_g": round(load.mass * 1000, 3),
        "centre_of_gravity_mm": np.round(load.centre * 1000, 3).tolist(),
        "inertia_kgm2": np.round(load.inertia, 9).tolist(),
    }


def _names(cell: Cell) -> str:
    return ", ".join(part.name for part in cell.parts) or "none"


def _problems(cell: Cell, arm: Arm, reach: Reach) -> Iterator[str]:
    _, _, velocity = cell.robot.limits(arm.joints)
    for joint, fast in zip(arm.joints, velocity, strict=True):
        if fast <= SLOW:
            yield f"{arm.name} arm: joint {joint} has no speed worth the name ({fast:g} rad/s)"
        if fast >= NO_SPEED:
            yield f"{arm.name} arm: joint {joint} has no speed limit ({fast:g} rad/s)"
    lean = lean_of(cell.robot, arm.flange)
    if lean > SKEW:
        yield (
            f"{arm.name} arm: z of flange {arm.flange} is turned {np.rad2deg(lean):.0f} degrees "
            "against the last axis, and the tool stands along it: name another link as flange"
        )
    if reach.at_home is not None:
        first, second = reach.at_home.pair
        distance = reach.at_home.distance * 1000
        carrier = cell.scanner.on_arm
        at = f"at view {carrier.view.name}" if carrier and carrier.arm == arm.name else "at home"
        how = f"overlap by {-distance:.1f} mm" if distance < 0 else f"are {distance:.1f} mm apart"
        yield f"{arm.name} arm: {at} {first} and {second} {how}"
    if not any(target.outcome == "clear" for target in reach.bin):
        yield f"{arm.name} arm: reaches no pose in the bin with the tool pointing down"
    if not reach.places and not reach.part_places:
        yield f"{arm.name} arm: has no place where it may release a part"
    elif reach.places and not any(target.outcome == "clear" for target in reach.places):
        yield f"{arm.name} arm: reaches none of its places"
    for placed in reach.part_places:
        if not placed.is_clear:
            where = f"{arm.name} arm: at place {placed.number} of parts {placed.part}"
            yield f"{where} {_not_placed(placed, cell.policy.margin * 1000)}"


def _slot_problems(cell: Cell) -> Iterator[str]:
    """Slots where an arm cannot put down their tool, straight in with it and back without."""
    for arm in cell.arms:
        for slot in arm.tool_slots:
            if (verdict := slot_problem(cell, arm.name, slot.tool)) is not None:
                yield f"{arm.name} arm: cannot put {slot.tool} into its slot: {verdict}"


def _not_placed(placed: PlacedPart, margin_mm: float) -> str:
    """What speaks against a part at a place."""
    by_each = f"by each of {placed.grasps} grasps"
    if placed.stands_in:
        return f"is nearer than {margin_mm:g} mm to {placed.stands_in}"
    if not placed.grasps:
        return "has no grasp that the arm may use"
    if not placed.reached:
        return f"is out of reach {by_each}, {placed.away * 1000:.0f} mm at best"
    return (
        f"is out of reach or brings the arm nearer than {margin_mm:g} mm to something {by_each} "
        f"({placed.reached} reach it)"
    )


def _axes(cell: Cell, arm: Arm) -> list[tuple[str, ...]]:
    lower, upper, velocity = (np.rad2deg(limit) for limit in cell.robot.limits(arm.joints))
    home = np.rad2deg(np.asarray(arm.home))
    rows: list[tuple[str, ...]] = []
    for axis, (k, sign) in enumerate(zip(arm.axis_order, arm.axis_signs, strict=True), start=1):
        low, high = sorted((sign * lower[k], sign * upper[k]))
        values = (low, high, velocity[k], sign * home[k])
        rows.append((str(axis), arm.joints[k], *(f"{value:.1f}" for value in values)))
    return rows


def _share(targets: Sequence[Target | PlacedPart]) -> dict[str, int]:
    return dict(Counter(target.outcome for target in targets))


def _words(reach: Reach) -> tuple[str, ...]:
    of_all = (*reach.places, *reach.part_places)
    found, places = _share(reach.bin), _share(of_all)
    return (
        reach.arm,
        str(len(reach.bin)),
        *(
            f"{found.get(outcome, 0) / len(reach.bin):.0%}"
            for outcome in ("clear", "in collision", "out of reach")
        ),
        f"{places.get('clear', 0)} of {len(of_all)}",
    )


def _form(reach: Reach) -> dict[str, object]:
    return {
        "arm": reach.arm,
        "clear_at_home": reach.at_home is None,
        "bin": _share(reach.bin),
        "places": _share(reach.places),
        "part_places": [
            {
                "number": place.number,
                "part": place.part,
                "outcome": place.outcome,
                "stands_in": place.stands_in,
                "grasps": place.grasps,
                "reached": place.reached,
            }
            for place in reach.part_places
        ],
    }
