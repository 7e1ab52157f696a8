"""The Acme Pincer in two sizes."""

from dataclasses import dataclass

import numpy as np

from workbench.model.cell import Finger, Tool
from workbench.model.geometry import Box, Cylinder, Solid, pose_from_rpy
from workbench.plugins.options import option

PALM, FINGER = 0.07, 0.05
"""[m] Heights of body and fingers."""


class Pincer:
    """Two fingers on a round body."""

    @dataclass(frozen=True)
    class Options:
        """Keys in `[tool.options]`."""

        size: str = option("small", among=("small", "large"), says="of the Pincer")

    def make(self, name: str, options: Options) -> Tool:
        """Its TCP lies between the finger tips."""
        stroke = 0.04 if options.size == "small" else 0.08
        fingers = tuple(
            Finger(
                Solid(
                    f"{name}_finger_{number}",
                    Box(np.array([0.005, 0.01, FINGER])),
                    pose_from_rpy((side * 0.0025, 0.0, PALM + FINGER / 2)),
                ),
                np.array([float(side), 0.0, 0.0]),
            )
            for number, side in enumerate((1, -1))
        )
        body = Solid(f"{name}_body", Cylinder(0.03, PALM), pose_from_rpy((0.0, 0.0, PALM / 2)))
        tcp = pose_from_rpy((0.0, 0.0, PALM + FINGER))
        return Tool(name, tcp, (body,), fingers, (0.0, stroke))
