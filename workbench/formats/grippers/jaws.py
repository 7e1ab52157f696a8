"""What moves of a gripper: its two tips, how they open, and what swings behind them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from workbench.model.errors import InputError
from workbench.model.geometry import Floats

SAME_WAY = 1e-4
"""[m] A link that goes along with the tip so closely is one finger with it."""

MOST_SWING = 0.005
"""[m] By how much tips of a linkage may come forward as they close, unless somebody wants more."""

END = 0.3
"""Share of the length of a finger by which it takes parts."""

SAME_REACH = 0.005
"""[m] What reaches nearly as far as the tips of two fingers is a third one."""

LEAST_STROKE = 0.005
"""[m] What opens by less is no gripper."""


@dataclass(frozen=True, slots=True, eq=False)
class MovingLink:
    """The points (n, 3) [m] of a link in the root's frame, at each opening."""

    name: str
    points: tuple[Floats, ...]

    @property
    def middles(self) -> Floats:
        """Of the points at each opening (k, 3) [m]."""
        return np.array([points.mean(axis=0) for points in self.points])


@dataclass(frozen=True, slots=True, eq=False)
class Jaws:
    """What moves of a gripper, sorted.

    `along` (3,) is where it points, `apart` (3,) where the first of the two `tips` opens, `middle`
    [m] where they meet along that.  `behind` is what else moves; `moving` names all links that do.
    `openings` (n,) [m] are the distances of the tips, `most` the largest that the gripper has.
    """

    along: Floats
    apart: Floats
    middle: float
    tips: tuple[MovingLink, MovingLink]
    behind: tuple[MovingLink, ...]
    moving: frozenset[str]
    openings: Floats
    most: float = 0.0

    @classmethod
    def of(cls, moving: Sequence[MovingLink], name: str) -> "Jaws":
        """Find the two tips among the links that move, and how they open.

        Raises:
            InputError: the links do not move to two sides.
        """
        if len(moving) < 2:
            raise InputError(f"gripper {name}: two fingers are expected, {len(moving)} link moves")
        every = np.concatenate([points for link in moving for points in link.points])
        along = nearest_axis(every.mean(axis=0))
        travels = [link.middles[-1] - link.middles[0] for link in moving]
        across = [travel - (travel @ along) * along for travel in travels]
        widest = max(across, key=lambda travel: float(np.linalg.norm(travel)))
        if np.linalg.norm(widest) < LEAST_STROKE / 2:
            raise InputError(f"gripper {name}: its fingers do not move apart along a line")
        apart = widest / np.linalg.norm(widest)
        half = float((every @ apart).min() + (every @ apart).max()) / 2
        sides = [
            [link for link in moving if (link.middles.mean(axis=0) @ apart > half) == is_first]
            for is_first in (True, False)
        ]
        if not all(sides):
            raise InputError(f"gripper {name}: only one finger moves; two are expected")
        tips = tuple(max(side, key=lambda link: _farthest(link, along)) for side in sides)
        with_tips = [
            [link for link in side if link is tip or _goes_along(link, tip)]
            for side, tip in zip(sides, tips, strict=True)
        ]
        first, second = (_joined(links) for links in with_tips)
        low = np.array([(_end(points, along) @ apart).min() for points in first.points])
        high = np.array([(_end(points, along) @ apart).max() for points in second.points])
        inner = np.array([low, high])
        behind = tuple(link for link in moving if not any(link in links for links in with_tips))
        middle = float(inner.mean())
        reach = min(_farthest(tip, along) for tip in tips)
        if third := [link.name for link in behind if _farthest(link, along) > reach - SAME_REACH]:
            raise InputError(f"gripper {name}: two fingers are expected, {third[0]} is a third one")
        names = frozenset(link.name for link in moving)
        return cls(along, apart, middle, (first, second), behind, names, low - high)

    def within(self, widest: float | None) -> "Jaws":
        """The same as far as it opens by `widest` [m]; see `gripper_of`."""
        if widest is None:
            reaches = np.array([self._reach(k) for k in range(len(self.openings))])
            order = np.argsort(self.openings)
            is_near = np.maximum.accumulate(reaches[order]) - reaches[order] <= MOST_SWING
            stays = order[np.logical_and.accumulate(is_near)]
        else:
            stays = np.flatnonzero(self.openings <= widest)
        stays = np.sort(stays)

        def cut(link: MovingLink) -> MovingLink:
            return replace(link, points=tuple(link.points[k] for k in stays))

        first, second = map(cut, self.tips)
        behind = tuple(map(cut, self.behind))
        most = float(self.openings.max())
        return replace(
            self, tips=(first, second), behind=behind, openings=self.openings[stays], most=most
        )

    def _reach(self, sample: int) -> float:
        """How far [m] along both tips reach at one of the openings."""
        return min(float((tip.points[sample] @ self.along).max()) for tip in self.tips)

    @property
    def stroke(self) -> tuple[float, float]:
        """The smallest and the largest opening [m]."""
        return max(float(self.openings.min()), 0.0), max(float(self.openings.max()), 0.0)

    @property
    def tip_z(self) -> float:
        """How far [m] along both tips reach at every opening."""
        return min(self._reach(k) for k in range(len(self.openings)))

    @property
    def notes(self) -> tuple[str, ...]:
        """What was decided, for people."""
        axis = "xyz"[int(np.argmax(np.abs(self.along)))]
        low, high = (1000 * opening for opening in self.stroke)
        first, second = (tip.name for tip in self.tips)
        notes = [
            f"fingers {first} and {second} open by {low:.1f} to {high:.1f} mm; the TCP is between "
            f"them, {1000 * self.tip_z:.1f} mm along {axis} of the root link"
        ]
        if high + 1 < 1000 * self.most:
            notes.append(
                f"it opens up to {1000 * self.most:.1f} mm; wider its tips draw back, which "
                "straight fingers cannot: --widest-mm takes more of it"
            )
        if self.along[2] < 0.5:
            notes.append("the gripper does not point along z of its root link: look at its pose")
        if self.behind:
            names = ", ".join(link.name for link in self.behind)
            notes.append(f"{names}: counted as body at all places that they get to")
        return tuple(notes)


def _goes_along(link: MovingLink, tip: MovingLink) -> bool:
    """Whether a link goes as the tip of its finger does, and turns no more than that."""
    shifts = tip.middles - tip.middles[0]
    return all(
        float(np.abs(points - shift - link.points[0]).max()) < SAME_WAY
        for points, shift in zip(link.points, shifts, strict=True)
    )


def _end(points: Floats, along: Floats) -> Floats:
    """The points (m, 3) [m] of a finger's end: farther back its carriage may pass the middle."""
    far = points @ along
    return np.asarray(points[far >= far.max() - END * np.ptp(far)])


def _joined(links: Sequence[MovingLink]) -> MovingLink:
    """Links of one finger as one."""
    every = zip(*(link.points for link in links), strict=True)
    return MovingLink(links[-1].name, tuple(np.concatenate(points) for points in every))


def nearest_axis(direction: Floats) -> Floats:
    """The unit vector (3,) along an axis of the frame that a direction (3,) is nearest to."""
    axis = np.zeros(3)
    largest = int(np.argmax(np.abs(direction)))
    axis[largest] = np.sign(direction[largest]) or 1.0
    return axis


def _farthest(link: MovingLink, along: Floats) -> float:
    return max(float((points @ along).max()) for points in link.points)
