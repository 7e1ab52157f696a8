"""Kind and rotation of a part by colour, where shape leaves several possible.

Shape decides first.  The remaining guesses are other kinds at the same place, and rotations of the
part's shape onto itself.  They are compared in pairs, at the points where their colours differ.  A
guess is excluded if the other is clearly nearer to the seen colours under every light that explains
the whole scan.  So a dim, noisy or tinted scan decides less, and a scan without colours nothing.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from workbench.model.geometry import Bools, Floats, own
from workbench.model.scan import Objection, Scan
from workbench.perception.colours.light import SPREAD, UNLIKE, are_unlike, distances, spread
from workbench.perception.colours.painted import (
    Painted,
    is_same_surface,
    painted,
    points_on,
)
from workbench.perception.colours.rivals import Guess, ShapeScores
from workbench.perception.localization.assessment import Assessment
from workbench.perception.localization.choice import Choice, PartSearch
from workbench.perception.localization.judging import without
from workbench.perception.views.srgb import linear

FITS = 8.0
"""Mean squared distance, in deviations, up to which colours seen are those of a guess at all."""

AS_GOOD = 4.0
"""Largest excess of a possible light's error over all parts, relative to the best light."""

FEWEST_POINTS, LEAST_SHARE = 12, 0.03
"""Points, and share of those seen, by which two guesses must differ to be distinguished."""


@dataclass(frozen=True, slots=True, eq=False)
class SeenPart:
    """A part that was chosen, guesses at it by its shape, and how each fits under each light.

    `table` (g, n, l) are squared distances of n points as `light.distances` has them, None of a
    scan without colours; `paints` (g, n, 3), 0..1, are those that each guess predicts.
    """

    kind: int
    number: int
    shape: ShapeScores
    guesses: Sequence[Guess]
    paints: Floats
    table: Floats | None

    def __post_init__(self) -> None:
        own(self, "paints")

    def misses(self) -> Floats:
        """Mean squared distance (g, l) of each guess under each light."""
        assert self.table is not None
        return self.table.mean(axis=1)

    def excludes(self, better: int, worse: int, lights: Bools, deviation: Floats) -> bool:
        """Whether one guess excludes another under all of those lights (l,)."""
        if self.table is None:
            return False
        differ = are_unlike(self.paints[better], self.paints[worse], deviation)
        if np.count_nonzero(differ) < max(FEWEST_POINTS, LEAST_SHARE * len(differ)):
            return False
        better_fit, worse_fit = (
            self.table[g][differ][:, lights].mean(axis=0) for g in (better, worse)
        )
        return bool((better_fit <= FITS).all() and (worse_fit - better_fit >= UNLIKE).all())


@dataclass(frozen=True, slots=True, eq=False)
class ColourReading:
    """What colours say of a part that was chosen: of which kind it is, and how it lies."""

    kind: int
    number: int
    guess: Guess
    assessed: Assessment


def resolve_by_colour(scan: Scan, searches: Sequence[PartSearch]) -> list[PartSearch]:
    """The searches of all kinds, each part that was chosen as its colours show it.

    Args:
        scan: with or without colours.
        searches: what was found by shape, of all kinds.
    """
    kinds = [painted(search.part, search.surface) for search in searches]
    if all(kind is None for kind in kinds):
        return list(searches)
    on = {
        (k, i): points_on(scan, search.surface, chosen.pose, search.tolerance)
        for k, search in enumerate(searches)
        if kinds[k] is not None
        for i, chosen in enumerate(search.choice.chosen)
    }
    deviation = _deviation(scan, list(on.values()))
    seen = [_look(scan, searches, kinds, part, points, deviation) for part, points in on.items()]
    total = sum((each.misses().min(axis=0) for each in seen if each.table is not None), np.zeros(1))
    lights = total <= total.min() + AS_GOOD
    decisions = [
        _decide(searches, kinds, each, lights, int(total.argmin()), deviation) for each in seen
    ]
    return _chosen_anew(searches, decisions)


def _deviation(scan: Scan, on: Sequence[np.ndarray]) -> Floats:
    points = np.unique(np.concatenate(on)) if on else np.empty(0, np.int64)
    if scan.colours is None or len(points) < 2:
        return np.array(SPREAD)
    return spread(scan.points[points], scan.colours[points])


def _look(
    scan: Scan,
    searches: Sequence[PartSearch],
    kinds: Sequence[Painted | None],
    part: tuple[int, int],
    on: np.ndarray,
    deviation: Floats,
) -> SeenPart:
    """Compare the accepted part `i` of kind `k`, `part` = (k, i), with its guesses."""
    k, i = part
    surfaces = [each.surface for each in searches]
    shape = ShapeScores(searches[k], surfaces, searches[k].choice.chosen[i].pose)
    points, some = scan.points[on], shape.guesses(kinds)
    each = [kinds[guess.kind].at(points, guess.pose) for guess in some]  # type: ignore[union-attr]
    paints = np.array(each)
    if scan.colours is None or not len(on):
        return SeenPart(k, i, shape, some, paints, None)
    different, which = np.unique(paints.reshape(-1, 3), axis=0, return_inverse=True)
    table = distances(linear(scan.colours[on]), different, deviation)
    rows = np.arange(len(on))
    found = [table[rows, paint] for paint in which.reshape(len(some), len(on))]
    return SeenPart(k, i, shape, some, paints, np.array(found))


def _decide(
    searches: Sequence[PartSearch],
    kinds: Sequence[Painted | None],
    seen: SeenPart,
    lights: Bools,
    light: int,
    deviation: Floats,
) -> ColourReading:
    """What stands of the guesses at a part; `light` is the likeliest."""
    search = searches[seen.kind]
    own = search.choice.chosen[seen.number]
    shape = seen.shape
    every = range(len(seen.guesses))
    # The pose found comes first, so it stays where nothing is nearer.
    order = [0] if seen.table is None else np.argsort(seen.misses()[:, light], kind="stable")
    best = next(int(g) for g in order if shape.allows(seen.guesses[int(g)]) is not None)
    if best and not seen.excludes(best, 0, lights, deviation):
        best = 0
    chosen = seen.guesses[best]
    rivals = [g for g in every if not _is_alike(chosen, seen.guesses[g])]
    left = [g for g in rivals if not seen.excludes(best, g, lights, deviation)]
    bare = [k for k, kind in enumerate(kinds) if kind is None]
    is_open = any(shape.allows(seen.guesses[g]) is not None for g in left) or any(
        shape.allows(Guess(k, own.pose, np.empty((0, 3)))) is not None for k in bare
    )
    if not is_open and all(shape.allows(seen.guesses[g]) is None for g in rivals):
        return ColourReading(seen.kind, seen.number, chosen, own)
    kind = kinds[chosen.kind]
    assert kind is not None
    pose = shape.allows(chosen)
    assert pose is not None
    target = searches[chosen.kind]
    assessed = replace(
        own,
        pose=pose,
        sighting=target.look(pose),
        share=1.0 if not is_open and _flips_show(kind) else own.share,
        by_colour=not is_open,
    )
    return ColourReading(seen.kind, seen.number, chosen, assessed)


def _is_alike(first: Guess, second: Guess) -> bool:
    """Whether two guesses are of one kind and no colour on all of it distinguishes them."""
    return first.kind == second.kind and is_same_surface(first.shown, second.shown)


def _flips_show(kind: Painted) -> bool:
    """Whether a part that lies the other way round shows it by its colours."""
    symmetry = kind.surface.symmetry
    flips = symmetry.motions[max(len(symmetry.turns), 1) :]
    itself = kind.shows(np.eye(4))
    return not any(is_same_surface(itself, kind.shows(flip)) for flip in flips)


def _chosen_anew(
    searches: Sequence[PartSearch], decisions: Sequence[ColourReading]
) -> list[PartSearch]:
    """The searches with the decisions by colour applied to kinds and rotations."""
    choices = [
        Choice(
            search.choice.claimed.copy(),
            list(search.choice.chosen),
            list(search.choice.rejected),
        )
        for search in searches
    ]
    for decision in decisions:
        if decision.guess.kind == decision.kind:
            choices[decision.kind].chosen[decision.number] = decision.assessed
    lost = [
        {
            decision.number: Objection.COLOURS
            for decision in decisions
            if k == decision.kind != decision.guess.kind
        }
        for k in range(len(searches))
    ]
    choices = [without(*each) for each in zip(choices, lost, strict=True)]
    for decision in decisions:
        if decision.guess.kind != decision.kind:
            choice, explained = choices[decision.guess.kind], decision.assessed.sighting.explained
            # Mostly that kind was found there too.
            if np.count_nonzero(choice.claimed[explained] >= 0) < len(explained) / 2:
                choice.claimed[explained] = len(choice.chosen)
                choice.chosen.append(decision.assessed)
    return [
        replace(search, choice=choice) for search, choice in zip(searches, choices, strict=True)
    ]
