"""A part to be picked, and the grasps that people put on it."""

from dataclasses import dataclass, field, replace

import numpy as np
import pinocchio as pin

from workbench.model.digest import digest_of
from workbench.model.geometry import Floats, Mesh, Solid, copied, frozen, put


@dataclass(frozen=True, slots=True, eq=False)
class Symmetry:
    """Rotations about `axis` (through the part's origin) that leave the part as it is.

    `fold` 1: none; n: turns of 360/n degrees; 0: any angle.
    """

    axis: Floats = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))
    fold: int = 1

    def __post_init__(self) -> None:
        put(self, axis=frozen(self.axis))


@dataclass(frozen=True, slots=True, eq=False)
class Grasp:
    """Where and how a tool takes the part.  The TCP's z axis points into the part.

    `approach` (3,) and `retreat` (3,) are unit directions of travel in the TCP frame, with
    their lengths in m: the tool arrives along `approach` over `approach_length`.  When
    `retreat` is None the extraction follows the cell's policy (lift, leaning to the bin
    centre).  `opening` [m] is the finger distance on arrival, `grip` [m] when closed on the
    part.  `arms` empty means any arm.  `free_rotation` [rad] is how far the tool may turn
    about its own z either way.  `tool` is the one it is for; empty means any.
    """

    name: str
    T_part_tcp: pin.SE3
    opening: float
    grip: float
    approach: Floats = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))
    approach_length: float = 0.06
    retreat: Floats | None = None
    retreat_length: float = 0.1
    priority: int = 0
    is_enabled: bool = True
    arms: tuple[str, ...] = ()
    free_rotation: float = 0.0
    tool: str = ""

    def __post_init__(self) -> None:
        put(
            self,
            T_part_tcp=copied(self.T_part_tcp),
            approach=frozen(self.approach),
            retreat=None if self.retreat is None else frozen(self.retreat),
        )


@dataclass(frozen=True, slots=True, eq=False)
class GraspPattern:
    """One grasp repeated around and along an axis of the part, kept editable as one thing.

    `axis` (3,) runs through the part's origin; the copies are turned by each of `angles` [rad]
    about it and moved by each of `offsets` [m] along it.
    """

    grasp: Grasp
    axis: Floats
    angles: tuple[float, ...]
    offsets: tuple[float, ...]

    def __post_init__(self) -> None:
        put(self, axis=frozen(self.axis))

    @property
    def grasps(self) -> tuple[Grasp, ...]:
        """The copies, named `<name>-<row>-<column>` by offset and angle, counted from 1."""
        return tuple(
            replace(
                self.grasp,
                name=f"{self.grasp.name}-{row}-{column}",
                T_part_tcp=pin.SE3(
                    pin.AngleAxis(angle, np.array(self.axis)).matrix(), offset * self.axis
                )
                * self.grasp.T_part_tcp,
            )
            for row, offset in enumerate(self.offsets, start=1)
            for column, angle in enumerate(self.angles, start=1)
        )


@dataclass(frozen=True, slots=True, eq=False)
class GraspLibrary:
    """All grasps of a part, as authored: single ones and patterns.

    `grasps` holds every single one, patterns written out, in authored order.
    """

    entries: tuple[Grasp | GraspPattern, ...] = ()
    grasps: tuple[Grasp, ...] = field(init=False, repr=False, metadata={"derived": True})

    def __post_init__(self) -> None:
        grasps = [
            grasp
            for entry in self.entries
            for grasp in (entry.grasps if isinstance(entry, GraspPattern) else (entry,))
        ]
        put(self, grasps=tuple(grasps))


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """A part: its surface, convex solids for collision and physics, symmetry and grasps."""

    name: str
    mesh: Mesh
    pieces: tuple[Solid, ...]
    mass: float
    symmetry: Symmetry
    library: GraspLibrary
    digest: str = field(init=False, repr=False)

    def __post_init__(self) -> None:
        put(self, digest=digest_of(self))
