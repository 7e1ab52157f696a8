"""Stations and regions of a cell, and the parts that stand beside the bin: there, and at places."""

from collections.abc import Sequence

import numpy as np
import pinocchio as pin
import viser

from workbench.app.core.state import Phase
from workbench.app.picking.pallets import at_rest
from workbench.app.picking.stations import stands_on_station
from workbench.gui.scene.contacts import add_body
from workbench.gui.scene.marks import add_lines
from workbench.gui.scene.robot import place_new
from workbench.gui.shared.colours import BESIDE_BIN, BRAND, STATION, rgb_of
from workbench.gui.shared.look import View
from workbench.gui.texts.scene import PosePageText
from workbench.model.cell import Cell
from workbench.model.derived.assembling import seen_pose
from workbench.model.geometry import Floats, frozen
from workbench.model.part import Bin, Region, Station
from workbench.model.recipes.seen_base import SeenBase
from workbench.model.scan import Detection

MARK_HEIGHT = 0.0003
"""[m] A mark lies so much above the surface that it marks."""

SAME_PART_WITHIN = 0.001
"""[m] Parts no farther apart are one and the same."""


def add_stations(scene: viser.SceneApi, cell: Cell) -> None:
    """The level surfaces on which parts may stand for a moment, each with its name."""
    for station in cell.stations:
        name = f"/stations/{station.name}"
        place_new(scene.add_frame(name, show_axes=False), cell.T_world_station(station))
        length, width = station.size
        scene.add_box(
            f"{name}/surface",
            STATION,
            dimensions=(length, width, MARK_HEIGHT),
            opacity=0.5,
            position=(0.0, 0.0, MARK_HEIGHT / 2),
        )
        add_lines(scene, f"{name}/edge", edge_of(station), STATION, 2.5)
        scene.add_label(
            f"{name}/label",
            str(PosePageText.STATION(name=station.name)),
            font_screen_scale=0.8,
            anchor="top-center",
            position=(0.0, 0.0, -0.02),
        )


def add_regions(scene: viser.SceneApi, bin: Bin) -> None:
    """The edges of the boxes from which parts are taken, each with its name."""
    for number, region in enumerate(bin.regions):
        name = f"/regions/{number}"
        place_new(scene.add_frame(name, show_axes=False), bin.T_world_bin * region.T_bin_region)
        add_lines(scene, f"{name}/edges", edges_of(region), rgb_of(BRAND), 2.0)
        scene.add_label(
            f"{name}/label",
            f"region {region.name}",
            font_screen_scale=0.8,
            anchor="bottom-center",
            position=(0.0, 0.0, float(region.size[2])),
        )


def edges_of(region: Region) -> Floats:
    """The edges of a region's box as lines (12, 2, 3) [m] in its own frame."""
    length, width, height = region.size
    flat = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]]) * [length / 2, width / 2]
    low = np.column_stack([flat, np.zeros(4)])
    high = low + [0.0, 0.0, height]
    rings = [np.stack([ring, np.roll(ring, -1, axis=0)], axis=1) for ring in (low, high)]
    return frozen(np.concatenate([*rings, np.stack([low, high], axis=1)]))


def edge_of(station: Station) -> Floats:
    """The border of a station's surface as lines (4, 2, 3) [m] in its own frame."""
    half = np.asarray(station.size) / 2
    corners = np.array([[x, y] for x, y in ((1, 1), (-1, 1), (-1, -1), (1, -1))]) * half
    points = np.column_stack([corners, np.full(4, 2 * MARK_HEIGHT)])
    return frozen(np.stack([points, np.roll(points, -1, axis=0)], axis=1))


class DrawnBeside:
    """Parts that were put down and stay, as far as no part of the plan is drawn for them.

    Concurrency: the renderer's thread.
    """

    def __init__(self, scene: viser.SceneApi):
        """None is drawn yet."""
        self._scene = scene
        self._drawn: tuple[tuple[Detection, ...], tuple[SeenBase, ...]] | None = (), ()

    def draw(self, view: View, Ts_world_part: Sequence[pin.SE3]) -> None:
        """Show what stands beside the bin; `Ts_world_part` are the poses of the plan's parts.

        No part is shown twice: on a station it is the one of the plan that comes and goes there.
        After a fault nobody knows where that is, and it may stand on the station as well.
        """
        shown = tuple(
            detection
            for detection in view.state.placed
            if not _is_shown(view, detection, Ts_world_part)
        )
        obstacles = view.state.obstacles
        Ts_seen = {id(placed): seen_pose(placed, obstacles) for placed in shown}
        moved = tuple(box.seen for box in obstacles if box.seen is not None)
        if (shown, moved) == self._drawn:
            return
        self._drawn = None  # until it is drawn
        self._scene.remove_by_name("/placed")
        known = {part.name: part.mesh for part in view.state.cell.parts}
        there = [detection for detection in view.state.placed if detection.part in known]
        for number, (detection, T) in enumerate(
            zip(there, at_rest(view.state.cell, there), strict=True)
        ):
            if detection in shown:
                T_shown = Ts_seen[id(detection)] or T
                name = f"/placed/{number}"
                add_body(self._scene, name, known[detection.part], T_shown, BESIDE_BIN)
        self._drawn = shown, moved


def _is_shown(view: View, detection: Detection, Ts_world_part: Sequence[pin.SE3]) -> bool:
    """Whether what stands beside the bin is a part that the film of the plan has to show."""
    state = view.state
    if state.phase is not Phase.FAULT and any(_are_one(T, detection) for T in Ts_world_part):
        return True  # where the hand has just let go of it
    stand = [
        T
        for plan in state.plans
        for arm in plan.arms
        if (T := stands_on_station(state.cell, plan, arm)) is not None and _are_one(T, detection)
    ]
    is_filmed = state.phase is Phase.SENDING or not view.look.follows
    return bool(stand) and (is_filmed or any(_are_one(T, detection) for T in Ts_world_part))


def _are_one(T_world_part: pin.SE3, detection: Detection) -> bool:
    away = T_world_part.translation - detection.T_world_part.translation
    return float(np.linalg.norm(away)) < SAME_PART_WITHIN
