"""Grippers in a few numbers, for cells that are planned before the real one is drawn."""

from dataclasses import dataclass

import numpy as np

from workbench.model.cell import Finger, Tool
from workbench.model.errors import InputError
from workbench.model.geometry import Box, Cylinder, Solid, pose_from_rpy
from workbench.plugins.options import option

GREY, DARK = (0.55, 0.57, 0.6), (0.25, 0.26, 0.3)


class ParallelGripper:
    """A box with two fingers that open along x of the flange."""

    @dataclass(frozen=True, slots=True)
    class Options:
        """Millimetres and newtons."""

        palm_mm: float = option(60.0, low=5, high=500, says="height of the body above the flange")
        width_mm: float = option(80.0, low=5, high=500, says="of the body, along the opening")
        depth_mm: float = option(40.0, low=5, high=500, says="of the body, across the opening")
        finger_mm: float = option(50.0, low=2, high=500, says="length of the fingers")
        thickness_mm: float = option(6.0, low=0.5, high=100, says="of a finger, along the opening")
        finger_width_mm: float = option(12.0, low=0.5, high=200, says="across the opening")
        stroke_mm: float = option(50.0, low=0.5, high=500, says="largest opening")
        force_n: float = option(0.0, low=0, high=1e5, says="of each finger; 0: not known")

    def make(self, name: str, options: Options) -> Tool:
        """Its TCP lies between the tips."""
        if options.stroke_mm + 2 * options.thickness_mm > 2 * options.width_mm:
            raise InputError("the fingers would open to more than twice the width of the body")
        palm, long, thick = (
            options.palm_mm / 1000,
            options.finger_mm / 1000,
            options.thickness_mm / 1000,
        )
        body = Box(np.array([options.width_mm, options.depth_mm, options.palm_mm]) / 1000)
        finger = Box(np.array([thick, options.finger_width_mm / 1000, long]))
        middle = palm + long / 2
        return Tool(
            name,
            pose_from_rpy((0.0, 0.0, palm + long)),
            (Solid(f"{name}_body", body, pose_from_rpy((0.0, 0.0, palm / 2)), GREY),),
            tuple(
                Finger(
                    Solid(
                        f"{name}_finger_{number}",
                        finger,
                        pose_from_rpy((side * thick / 2, 0.0, middle)),
                        DARK,
                    ),
                    np.array([float(side), 0.0, 0.0]),
                )
                for number, side in enumerate((1, -1), start=1)
            ),
            (0.0, options.stroke_mm / 1000),
            force=options.force_n or None,
        )


class SuctionCup:
    """A rod with one cup at its end."""

    @dataclass(frozen=True, slots=True)
    class Options:
        """Millimetres and newtons."""

        rod_mm: float = option(100.0, low=1, high=1000, says="length of the rod")
        rod_diameter_mm: float = option(12.0, low=1, high=200, says="of the rod")
        cup_mm: float = option(15.0, low=1, high=200, says="height of the cup")
        cup_diameter_mm: float = option(20.0, low=1, high=300, says="of the cup's lip")
        gives_way_mm: float = option(3.0, low=0, high=50, says="how far the lip is pressed in")
        force_n: float = option(0.0, low=0, high=1e5, says="by which it pulls; 0: not known")

    def make(self, name: str, options: Options) -> Tool:
        """Its TCP lies in the middle of the lip."""
        rod, cup = options.rod_mm / 1000, options.cup_mm / 1000

        def round_bar(part: str, diameter: float, length: float, middle: float) -> Solid:
            shape = Cylinder(diameter / 2000, length)
            return Solid(f"{name}_{part}", shape, pose_from_rpy((0.0, 0.0, middle)), DARK)

        return Tool(
            name,
            pose_from_rpy((0.0, 0.0, rod + cup)),
            (
                round_bar("rod", options.rod_diameter_mm, rod, rod / 2),
                round_bar("cup", options.cup_diameter_mm, cup, rod + cup / 2),
            ),
            press=options.gives_way_mm / 1000,
            force=options.force_n or None,
        )
