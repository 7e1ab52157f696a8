"""What else a part that was found could be by its shape: another kind, or turned otherwise."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from workbench.model.geometry import Bools, Floats, own
from workbench.perception.colours.painted import Painted
from workbench.perception.localization.alternatives import is_better
from workbench.perception.localization.assessment import FAR_BEHIND, refine_at_full_resolution
from workbench.perception.localization.choice import PartSearch
from workbench.perception.matching.sightings import closeness, tally
from workbench.perception.parts.part_surface import PartSurface


@dataclass(frozen=True, slots=True, eq=False)
class Guess:
    """A part of a kind, by its number, at a pose (4, 4) [m] in the scanner's frame.

    `shown` (c, 3) are its paints all over the surface that was found.
    """

    kind: int
    pose: Floats
    shown: Floats

    def __post_init__(self) -> None:
        own(self, "pose", "shown")


@dataclass(slots=True, eq=False)
class ShapeScores:
    """What shape says to guesses at a part that was found, each asked once.

    `found` (4, 4) [m] is its pose, `surfaces` are those of all kinds.
    """

    search: PartSearch
    surfaces: Sequence[PartSurface]
    found: Floats
    known: dict[Guess, Floats | None] = field(default_factory=dict[Guess, Floats | None])

    def guesses(self, kinds: Sequence[Painted | None]) -> list[Guess]:
        """What the part may be among kinds with colours by a glance, as it was found first.

        Kinds whose shape is the same have it in the same frame.
        """
        order = sorted(range(len(kinds)), key=lambda j: self.surfaces[j] is not self.search.surface)
        points = self.search.surface.coarse.points
        found = list[Guess]()
        for j in order:
            kind = kinds[j]
            if kind is not None:
                poses = self.found @ kind.motions
                near = np.flatnonzero(self._are_near(self.surfaces[j], poses))
                found += [Guess(j, poses[m], kind.at(points, kind.motions[m])) for m in near]
        return found

    def allows(self, guess: Guess) -> Floats | None:
        """The pose (4, 4) [m] of a guess, brought to rest; None where shape speaks against it."""
        if guess not in self.known:
            self.known[guess] = self._bring_to_rest(guess)
        return self.known[guess]

    def _are_near(self, surface: PartSurface, poses: Floats) -> Bools:
        """Which poses (k, 4, 4) of a kind are not seen far less well than the part found."""
        depth_map, tolerance = self.search.depth_map, self.search.tolerance
        own = closeness(tally(depth_map, self.search.surface, self.found[None], tolerance))[0]
        seen = closeness(tally(depth_map, surface, poses, tolerance))
        return np.asarray(seen >= (1.0 - FAR_BEHIND) * own)

    def _bring_to_rest(self, guess: Guess) -> Floats | None:
        surface = self.surfaces[guess.kind]
        if surface is self.search.surface and np.array_equal(guess.pose, self.found):
            return self.found
        if not self._are_near(surface, guess.pose[None])[0]:
            return None
        depth_map, tolerance = self.search.depth_map, self.search.tolerance
        own = tally(depth_map, self.search.surface, self.found[None], tolerance)[0]
        pose = refine_at_full_resolution(depth_map, surface, guess.pose[None], tolerance)
        return None if is_better(own, tally(depth_map, surface, pose, tolerance)) else pose[0]
