"""Whether the bin is where the cell says, and how full it is: a look at its rim and its inside.

The rim is a rectangular ring of known size.  Points at about its height are fitted to it by
Gauss-Newton steps with ever narrower weights (iteratively reweighted least squares): from the
place in the cell and, when too little of the rim is found there, from others around it.
"""

from typing import Any

import numpy as np
import pinocchio as pin

from workbench.model.calibration import BinCheck, Light
from workbench.model.geometry import Bools, Floats, pose_from_rpy, sampled, shift_and_turn
from workbench.model.messages.calibration import BinText
from workbench.model.messages.message import Message
from workbench.model.part import Bin
from workbench.model.scan import Scan
from workbench.perception.bins.bin_fit import SEARCHED_WITHIN, as_in_cell, fit_bin
from workbench.perception.bins.fill_level import LOW, Filling, filled

SEARCHED_AROUND = 0.08
"""[m] Around the bin that the rim is searched for."""

BAND = 0.02
"""[m] Above and below its height."""

MOST_POINTS, RIM_POINTS = 60_000, 1500
"""Points of the scan, and of the rim, that are checked; of more every second, third, ..."""

SCALES = (0.04, 0.04, 0.03, 0.02, 0.02, 0.01, 0.01, 0.006, 0.004, 0.004)
"""[m] Distances from which points no longer pull, step by step."""

NARROW_FROM_STEP = 5
"""The steps from this one on are for a place that is nearly right."""

ON_RIM = 0.003
"""[m] A point this near to the middle line of the rim shows it."""

OUTSIDE = (0.005, 0.013)
"""[m] Outside of the middle of a rim there is nothing as high as itself; on a heap there is."""

RIM_PIECE = 0.01
"""[m] Length of the pieces into which the rim is divided, each seen or not."""

SEEN_SHARE, SURE_SHARE, BETTER_BY = 0.4, 0.75, 0.2
"""Share of the rim that must be seen; beyond which no other place is tried; and by which another
place must show more of it than where the bin should be."""

MOVED_DISTANCE, MOVED_TURN = 0.003, np.deg2rad(1.0)
"""[m, rad] More than this the bin is somewhere else."""

OVER_RIM, FULL_SHARE = 0.01, 0.5
"""[m, share] Parts further above the rim are reported.  The bin is too full if it is filled to at
least this share; otherwise a part stands upright or leans on a wall."""

EMPTY = 0.004
"""Share of the floor that may be covered in an empty bin: noise."""

WHOLE_FLOOR = 0.95
"""Share of the floor below which the seen share is reported."""


def check_bin(scan: Scan, bin: Bin) -> BinCheck:
    """Look at the bin in a scan.

    Args:
        scan: organised or not, the robot out of the picture.
        bin: as the cell has it.
    """
    T_bin_scanner = bin.T_world_bin.actInv(scan.T_world_scanner)
    points = sampled(scan.points, MOST_POINTS)
    p_bin = points @ T_bin_scanner.rotation.T + T_bin_scanner.translation
    if not bin.has_walls:
        return _check_surface(p_bin, bin)
    T = rim_place(p_bin, bin)
    if T is None:
        above = filled(p_bin, bin, as_in_cell()).above
        finding = BinText.NO_RIM(reach=SEARCHED_AROUND)
        if above > OVER_RIM:
            finding = BinText.RIM_COVERED(reach=SEARCHED_AROUND, above=above)
        return BinCheck(None, 0.0, 0.0, None, above, "bad", (finding,))
    shift, turn = shift_and_turn(T)
    is_elsewhere = shift > MOVED_DISTANCE or turn > MOVED_TURN
    p_bin = (p_bin - T.translation) @ T.rotation
    seen = fit_bin(p_bin, pin.SE3.Identity(), bin, noise=0.0)
    filling = filled(p_bin, bin, seen)
    fill, above = filling.fill, filling.above
    findings: list[Message] = []
    if _is_too_full(fill, above):
        findings.append(BinText.TOO_FULL(above=above))
    elif above > OVER_RIM:
        findings.append(BinText.STANDS_OUT(above=above))
    if is_elsewhere:
        x, y, z = (f"{value:+.1f}" for value in np.round(T.translation * 1000, 1) + 0.0)
        findings.append(BinText.MOVED(shift=shift, turn=turn, x=x, y=y, z=z))
    if abs(seen.floor[0]) > MOVED_DISTANCE:
        off = BinText.FLOOR_HIGHER if seen.floor[0] > 0 else BinText.FLOOR_LOWER
        findings.append(off(off=float(abs(seen.floor[0]))))
    is_empty = _is_empty(filling, findings)
    if fill is None:
        findings.append(BinText.HARDLY_SEEN())
    light: Light = "warning" if findings else "good"
    return BinCheck(
        bin.T_world_bin * T,
        shift,
        turn,
        fill,
        above,
        light,
        tuple(findings),
        is_elsewhere=is_elsewhere,
        is_empty=is_empty,
    )


def _check_surface(p_bin: Floats, bin: Bin) -> BinCheck:
    """The same of a bin without walls: how high its floor lies, and how it leans, can be seen."""
    seen = fit_bin(p_bin, pin.SE3.Identity(), bin, noise=0.0)
    filling = filled(p_bin, bin, seen)
    fill, above = filling.fill, filling.above
    height = float(bin.size[2])
    findings: list[Message] = []
    if _is_too_full(fill, above):
        findings.append(BinText.OVERFILLED(above=above, height=height))
    elif above > OVER_RIM:
        findings.append(BinText.STANDS_TOO_HIGH(above=above, height=height))
    if not seen.is_floor_seen:
        findings.append(BinText.NO_SURFACE(reach=SEARCHED_WITHIN))
        return BinCheck(None, 0.0, 0.0, None, above, "bad", tuple(findings), has_walls=False)
    lean_x, lean_y = np.arctan2(2 * seen.floor[1:3], bin.size[:2])
    T = pose_from_rpy((0, 0, seen.floor[0]), (lean_y, -lean_x, 0))
    shift, turn = shift_and_turn(T)
    is_elsewhere = shift > MOVED_DISTANCE or turn > MOVED_TURN
    if is_elsewhere:
        off = f"{seen.floor[0] * 1000:+.1f}"
        findings.append(BinText.SURFACE_MOVED(off=off, turn=turn))
    is_empty = _is_empty(filling, findings)
    if fill is None:
        findings.append(BinText.SURFACE_HARDLY_SEEN())
    return BinCheck(
        bin.T_world_bin * T,
        shift,
        turn,
        fill,
        above,
        "warning" if findings else "good",
        tuple(findings),
        is_elsewhere=is_elsewhere,
        is_empty=is_empty,
        has_walls=False,
    )


def _is_empty(filling: Filling, findings: list[Message]) -> bool:
    """Whether nothing is seen to lie there; how flat a thing would be missed is a finding."""
    if filling.fill is None or filling.covered >= EMPTY:
        return False
    if filling.is_flat_seen:
        findings.append(BinText.ONLY_FLAT(low=LOW))
        return False
    if filling.seen < WHOLE_FLOOR:
        findings.append(BinText.EMPTY_AS_SEEN(lowest=filling.lowest, seen=filling.seen))
    else:
        findings.append(BinText.EMPTY(lowest=filling.lowest))
    return True


def _is_too_full(fill: float | None, above: float) -> bool:
    return above > OVER_RIM and (fill is None or fill >= FULL_SHARE)


def rim_place(p_bin: Floats, bin: Bin) -> pin.SE3 | None:
    """Where the bin is in its own frame as the cell has it; None where no rim is seen.

    Args:
        p_bin: (n, 3) [m] in that frame.
        bin: its size.
    """
    height, half = float(bin.size[2]), _half(bin)
    near = (np.abs(p_bin[:, :2]) < half + SEARCHED_AROUND).all(axis=1) & (
        abs(p_bin[:, 2] - height) < BAND
    )
    rim = p_bin[near]
    rim = sampled(rim, RIM_POINTS)
    best = (0.0, np.zeros(3))
    for number, start in enumerate(_starts()):
        # First only near where it should be: a heap pulls at whatever looks further.
        place = _fit(rim[:, :2], half, start, SCALES[NARROW_FROM_STEP:] if number == 0 else SCALES)
        share = _share_seen(rim[:, :2], half, place)
        # What is nearest to where it should be is preferred: a heap has edges, too.
        if share > best[0] + (BETTER_BY if best[0] >= SEEN_SHARE else 0.0):
            best = share, place
        if best[0] > SURE_SHARE:
            break
    share, place = best
    if share < SEEN_SHARE:
        return None
    plane = _plane(rim, half, place)
    # What belongs to the walls below the rim pulls inwards: now that its height is known, it is
    # left out.
    level = plane[0] * p_bin[:, 0] + plane[1] * p_bin[:, 1] + plane[2]
    top = p_bin[near & (np.abs(p_bin[:, 2] - level) < ON_RIM)]
    place = _fit(top[:, :2], half, place, SCALES[-3:])
    dx, dy, yaw = place
    turned = pose_from_rpy((0, 0, 0), (plane[1], -plane[0], 0)).rotation @ _yaw(yaw)
    rim_middle = np.array([dx, dy, plane[0] * dx + plane[1] * dy + plane[2]])
    return pin.SE3(turned, rim_middle - turned @ np.array([0.0, 0.0, height]))


def _half(bin: Bin) -> Floats:
    """Half the sizes (2,) [m] of the rectangle along the middle of the walls."""
    return (np.asarray(bin.size[:2]) + bin.wall) / 2


def _yaw(angle: float) -> Floats:
    return pin.rpy.rpyToMatrix(0.0, 0.0, float(angle))


def _starts() -> list[Floats]:
    """Shift [m] and turn [rad] from which the fit begins."""
    turns = [np.array([0.0, 0.0, angle]) for angle in (0.0, 0.0, 0.12, -0.12)]
    sides = [np.array([x, y, 0.0]) for x in (-0.04, 0.0, 0.04) for y in (-0.04, 0.0, 0.04)]
    return [*turns, *(side for side in sides if side.any())]


def _off(points: Floats, half: Floats, place: Floats) -> tuple[Floats, Bools, Floats]:
    """Signed distances (n,) to the nearest side, whether that is one across x, and its signs.

    Positive is outside.
    """
    local = _local(points, place)
    beyond = np.abs(local) - half
    is_x = beyond[:, 0] > beyond[:, 1]
    off = np.where(is_x, beyond[:, 0], beyond[:, 1])
    return off, is_x, np.sign(local)


def _local(points: Floats, place: Floats) -> Floats:
    return (points - place[:2]) @ _yaw(place[2])[:2, :2]


def _fit(points: Floats, half: Floats, start: Floats, scales: tuple[float, ...]) -> Floats:
    """The place (dx, dy, turn) at which points (n, 2) lie on the rectangle."""
    place = start.copy()
    if len(points) < 3:
        return place
    for scale in scales:
        off, is_x, signs = _off(points, half, place)
        weights = np.clip(1 - (off / scale) ** 2, 0, None)  # Tukey's, its root
        local = _local(points, place)
        sign = np.where(is_x, signs[:, 0], signs[:, 1])
        # By how much a side goes outwards when the rectangle moves along x, y, and turns.
        rows = np.stack(
            [
                np.where(is_x, sign, 0.0),
                np.where(is_x, 0.0, sign),
                np.where(is_x, -sign * local[:, 1], sign * local[:, 0]),
            ],
            axis=1,
        )
        weighted = rows * (weights**2)[:, None]
        step = np.linalg.solve(weighted.T @ rows + 1e-9 * np.eye(3), weighted.T @ off)
        place[:2] += _yaw(place[2])[:2, :2] @ step[:2]
        place[2] += step[2]
    return place


def _share_seen(points: Floats, half: Floats, place: Floats) -> float:
    """Which share of the rim is seen; 0 when the sides in one direction are not seen at all."""
    off, is_x, signs = _off(points, half, place)
    local = _local(points, place)
    on, outside = np.abs(off) < ON_RIM, (off > OUTSIDE[0]) & (off < OUTSIDE[1])
    seen, total = 0, 0
    for along, across in ((1, 0), (0, 1)):
        pieces = max(1, int(2 * half[along] / RIM_PIECE))
        at = np.clip((local[:, along] / (2 * half[along]) + 0.5) * pieces, 0, pieces - 1)
        piece = at.astype(int) + pieces * (signs[:, across] > 0)
        side = is_x if across == 0 else ~is_x
        shown = np.setdiff1d(piece[side & on], piece[side & outside])
        if len(shown) < SEEN_SHARE * pieces:
            return 0.0
        seen, total = seen + len(shown), total + 2 * pieces
    return seen / total


def _plane(rim: Floats, half: Floats, place: Floats) -> Floats:
    """Slopes along x and y, and height, of the plane through the rim."""
    off, _, _ = _off(rim[:, :2], half, place)
    on = rim[np.abs(off) < ON_RIM]
    # The walls below the rim are seen, too: it is the highest of them.
    level = np.percentile(on[:, 2], 85)
    for gate in (0.006, ON_RIM):
        kept = on[np.abs(on[:, 2] - level) < gate]
        rows = np.column_stack([kept[:, :2], np.ones(len(kept))])
        plane: Any = np.linalg.lstsq(rows, kept[:, 2], rcond=None)[0]
        level = plane[0] * on[:, 0] + plane[1] * on[:, 1] + plane[2]
    return plane
