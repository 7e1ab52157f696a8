"""Ways sampled from coarse to fine by the judge: which pair comes too near, if any."""

from collections import deque
from dataclasses import dataclass
from itertools import product

import numpy as np
from judge_scene import Scene

FINE, FINE_OF_TWO = 0.0002, 0.002
"""[m] Between two samples no point moves further from the nearer one; of two arms at any speeds."""

BEYOND = 0.0006
"""[m] The proof's resolution, and what the two measure differently."""

SLACK, ROOM = 0.0005, 0.0005
"""[m] What comes off its bed may come so much nearer to it; a hand that has left is so far away."""

CLEAR = 1e-6
"""[m] What is so far apart does not touch."""

ALIKE = 0.0001
"""[m] How far two libraries measure the same distance apart, where nothing moves."""

MOST = 20_000
"""Samples of one motion: then what was found so far is all that is said."""


@dataclass
class Refusal:
    """Why a plan must not be run: a rule, or two groups of bodies that come too near [m]."""

    why: str
    arms: tuple[str, ...] = ()
    legs: tuple[str, ...] = ()
    distance: float = 0.0
    need: float = 0.0


@dataclass(eq=False)
class Way:
    """A leg of an arm: `chords` [(from, to)] (nq,) of the arm's values, others 0; see `_way`."""

    one: object
    leg: object
    arm: str
    chords: list[tuple[np.ndarray, np.ndarray]]
    fingers: tuple[np.ndarray, np.ndarray] | None


@dataclass(eq=False)
class Asked:
    """Pairs of geoms (p, 2), and what they keep (p,) [m] now.

    `levers` (p, nq) [m/rad, m/m]: how far a value moves one of a pair against the other at most.
    """

    pairs: np.ndarray
    needs: np.ndarray
    levers: np.ndarray

    def only(self, chosen) -> "Asked":
        return Asked(self.pairs[chosen], self.needs[chosen], self.levers[chosen])

    def keeping(self, needs) -> "Asked":
        return Asked(self.pairs, needs, self.levers)


class Sampler:
    """Looks at samples of ways in a scene."""

    def __init__(self, scene: Scene, beyond: float) -> None:
        self.scene, self.beyond = scene, beyond

    def products(self, sides, asked: Asked, ways) -> Refusal | None:
        """The first pair that is too near on every combination of two arms' chords.

        `sides` are chords (from, to, columns) of each arm, whole configurations (nq,).
        """
        nodes = deque(((a[:2], b[:2], asked) for a, b in product(*sides)))
        columns, looks = sides[1][0][2], 0
        while nodes and looks < MOST:
            first, second, open_ = nodes.popleft()
            looks += 1
            q = onto(mix(*first, 0.5), mix(*second, 0.5), columns)
            spans = [np.abs(end - start) / 2 for start, end in (first, second)]
            found, stays = self._look(q, open_, spans[0] + spans[1], FINE_OF_TWO, ways)
            if found is not None:
                return found
            if not stays.any():
                continue
            left = open_.only(stays)
            moves = [(left.levers @ span).max() for span in spans]
            if moves[0] >= moves[1]:
                nodes.extend((half, second, left) for half in halves(*first))
            else:
                nodes.extend((first, half, left) for half in halves(*second))
        return None

    def along(self, chords, asked: Asked, *ways: Way) -> Refusal | None:
        """The first pair that is too near on straight chords, from coarse to fine."""
        if not len(asked.pairs):
            return None
        nodes = deque((start, end, asked) for start, end in chords)
        looks = 0
        while nodes and looks < MOST:
            start, end, open_ = nodes.popleft()
            looks += 1
            span = np.abs(end - start) / 2
            found, stays = self._look(mix(start, end, 0.5), open_, span, FINE, ways)
            if found is not None:
                return found
            if stays.any():
                left = open_.only(stays)
                nodes.extend((*half, left) for half in halves(start, end))
        return None

    def _look(self, q, asked: Asked, span, fine: float, ways):
        """A refusal, or which pairs (p,) have to be looked at more finely around `q`.

        `span` (nq,) is how far each value is from `q` at most; where a pair moves less than `fine`
        [m] this look stands for all of that.
        """
        scene = self.scene
        scene.at(q)
        a, b = asked.pairs.T
        way, radii = scene.data.geom_xpos[a], scene.model.geom_rbound
        way -= scene.data.geom_xpos[b]
        wanted = asked.levers @ span
        wanted += asked.needs + max(-self.beyond, 0.0)
        room = np.sqrt(np.einsum("ij,ij->i", way, way)) - radii[a] - radii[b]
        stays = np.zeros(len(a), bool)
        for k in np.flatnonzero(room < wanted).tolist():
            most = float(wanted[k])
            distance = scene.distance(int(a[k]), int(b[k]), most + 0.001)
            need = float(asked.needs[k])
            if distance < need - self.beyond:
                return self.refused(ways[0], asked, k, distance, need, "", *ways[1:]), stays
            stays[k] = distance < most and most - need > fine
        return None, stays

    def refused(self, way, asked: Asked, k, distance, need, said, *others) -> Refusal:
        pair = " and ".join(self.scene.group[g] for g in asked.pairs[k].tolist())
        arms = (way.arm, *(other.arm for other in others))
        legs = (way.leg.name, *(other.leg.name for other in others))
        return Refusal(f"{said}{pair}", arms, legs, float(distance), float(need))


def onto(base, values, columns) -> np.ndarray:
    q = base.copy()
    q[columns] = values[columns]
    return q


def mix(start, end, share) -> np.ndarray:
    return start + share * (end - start)


def halves(start, end):
    middle = mix(start, end, 0.5)
    return (start, middle), (middle, end)


def where(rises) -> float:
    """Where in 0..1 something rises above 0."""
    low, high = 0.0, 1.0
    for _ in range(30):
        middle = (low + high) / 2
        low, high = (middle, high) if rises(middle) < 0 else (low, middle)
    return high
