"""Noise, bin and surroundings in a scan, found once for all kinds that are searched in it."""

from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin

from workbench.model.cell import Cell
from workbench.model.geometry import Floats, sampled, shift_and_turn
from workbench.model.part import Bin
from workbench.model.scan import Scan
from workbench.perception.bins.bin_check import MOST_POINTS, SEARCHED_AROUND, rim_place
from workbench.perception.bins.bin_fit import (
    MOST_TILTED,
    SEARCHED_WITHIN,
    SEEN_WALL,
    SeenBin,
    fit_bin,
)
from workbench.perception.scene.sensor import FEWEST_POINTS, SensorModel, sensor_model
from workbench.perception.views.filling import densify, spacing_of

FEWEST_ACROSS, WANTED_ACROSS = 45, 100
"""Points across a part below which a sparse scan is filled in, and how many there are then."""

MOST_COUNTED = 50_000
"""Points by which a scan is found sparse; of more every second, third, ..."""


@dataclass(frozen=True, slots=True, eq=False)
class SceneModel:
    """The bin as the scan shows it, and how good the scan is.

    `place` is the cell's bin, moved to where its rim is seen if that is elsewhere, and `bin` its
    surfaces there.  `scan` is the scan that is searched, a sparse one filled in; `filled` is how
    many points it has for each one that was measured, at least 1.
    """

    place: Bin
    bin: SeenBin
    sensor: SensorModel
    scan: Scan
    filled: float = 1.0

    @property
    def points(self) -> Floats:
        """The points (n, 3) [m] that are searched, in the scanner's frame."""
        return self.scan.points


def scene_model(scan: Scan, cell: Cell, *, smallest: float = 0.0) -> SceneModel:
    """Look at a scan before the parts are searched for.

    Walls that are not seen, since the scanner looks along them, are where the rim says.

    Args:
        scan: organised or not.
        cell: its bin and scanner.
        smallest: [m] diameter of the smallest part, for which a sparse scan is filled in.
    """
    bin = cell.bin
    T_bin_scanner = bin.T_world_bin.actInv(scan.T_world_scanner)
    sensor = sensor_model(scan.points)
    deviation = sensor.deviation(
        float(np.linalg.norm(T_bin_scanner.translation)), otherwise=cell.scanner.depth_noise
    )
    dense, filled = _filled(scan.points, T_bin_scanner, bin, smallest)
    seen = fit_bin(dense, T_bin_scanner, bin, noise=deviation)
    if (seen.wall_shares < SEEN_WALL).any():
        points = sampled(dense, MOST_POINTS)
        T_bin_rim = rim_place(points @ T_bin_scanner.rotation.T + T_bin_scanner.translation, bin)
        if T_bin_rim is not None and _is_far(T_bin_rim):
            bin = replace(bin, T_world_bin=bin.T_world_bin * T_bin_rim)
            seen = fit_bin(dense, T_bin_rim.actInv(T_bin_scanner), bin, noise=deviation)
            T_bin_rim = pin.SE3.Identity()
        seen = _by_rim(seen, T_bin_rim, bin)
    if filled > 1.0:
        # Made here, as each kind of part is searched for in it.
        scan = Scan(dense, scan.T_world_scanner, scan.source)
    return SceneModel(bin, seen, sensor, scan, filled)


def _is_far(T_bin_rim: pin.SE3) -> bool:
    """Whether a rim lies further away than floor and walls are searched for."""
    shift, turn = shift_and_turn(T_bin_rim)
    return shift > SEARCHED_WITHIN or turn > MOST_TILTED


def _filled(
    points: Floats, T_bin_scanner: pin.SE3, bin: Bin, smallest: float
) -> tuple[Floats, float]:
    """The points (n, 3) [m] around the bin, a sparse cloud filled in, and by how many times."""
    few = sampled(points, MOST_COUNTED)
    around = _around(few, T_bin_scanner, bin)
    if not smallest > 0.0 or len(around) < FEWEST_POINTS:
        return points, 1.0
    spacing, _, _ = spacing_of(around)
    distance = float(np.median(around[:, 2]))
    spacing *= float(np.sqrt(len(few) / len(points)))
    if not spacing * distance > smallest / FEWEST_ACROSS / np.sqrt(2):
        return points, 1.0
    around = _around(points, T_bin_scanner, bin)
    dense = densify(around, smallest / WANTED_ACROSS)
    return dense, len(dense) / len(around)


def _around(points: Floats, T_bin_scanner: pin.SE3, bin: Bin) -> Floats:
    """Those of the points (n, 3) [m] that lie before the scanner, over the bin or close to it."""
    x, y, _ = (points @ T_bin_scanner.rotation.T + T_bin_scanner.translation).T
    reach = bin.size[:2] / 2 + SEARCHED_AROUND
    return points[(np.abs(x) < reach[0]) & (np.abs(y) < reach[1]) & (points[:, 2] > 0)]


def _by_rim(seen: SeenBin, T_bin_rim: pin.SE3 | None, bin: Bin) -> SeenBin:
    """The bin with the surfaces that are not seen where its rim is, if that is seen."""
    if T_bin_rim is None:
        return seen
    shift, turn = T_bin_rim.translation, pin.log3(T_bin_rim.rotation)
    walls = np.where((seen.wall_shares < SEEN_WALL)[:, None], _walls(shift, turn, bin), seen.walls)
    # Half the floor's sides take the tilt to metres, as its coefficients are.
    tilts = turn[[1, 0]] * (-1.0, 1.0) * bin.size[:2] / 2
    floor = seen.floor if seen.is_floor_seen else np.array([shift[2], *tilts, 0.0, 0.0, 0.0])
    return replace(seen, floor=_round(floor), walls=_round(walls))


def _walls(shift: Floats, turn: Floats, bin: Bin) -> Floats:
    """How far further out (4, 3) the walls are of a bin that is moved a little; see `SeenBin`."""
    length, width, height = bin.size
    x = np.array([shift[0], -turn[2] * width / 2, turn[1] * height])
    y = np.array([shift[1], turn[2] * length / 2, -turn[0] * height])
    return np.array([x, -x, y, -y])


def _round(values: Floats) -> Floats:
    """To micrometres, so that they are the same on any machine."""
    return np.round(values, 6) + 0.0
