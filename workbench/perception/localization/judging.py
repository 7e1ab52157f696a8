"""Which of all that was found stands: what is left when the parts of all kinds are held together.

A part that hides half of another one speaks for neither while it is not known itself, so this comes
last.  What something unknown explains better goes, the worst first, since parts vouch for each
other; then what does not end where it should.  The rest is asked again, until nothing goes.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from workbench.model.geometry import Bools
from workbench.model.scan import Objection
from workbench.perception.localization.choice import Choice, Hypothesis, PartSearch, Rejection
from workbench.perception.localization.outline import MOST_BENT, has_visible_boundary
from workbench.perception.matching.likelihood import log_likelihood_ratio, looked_through
from workbench.perception.matching.sightings import look

DOUBTED = 0.1
"""[nat] A part through which the scan looks by more, in the mean over what it explains, is in
doubt: it may explain one face and have the others elsewhere.  Of 680 that were right in simulated
piles, as five kinds of scanner see them, two had more; of 19 that were wrong two, 0.15 and 0.33."""


SAME_SURFACE = 0.7
"""Parts of two kinds of which each explains this share of the other's pixels stand in one place."""


@dataclass(frozen=True, slots=True, eq=False)
class JudgedChoice:
    """A choice without what does not stand, and the log likelihood ratio [nat] of what does."""

    choice: Choice
    ratios: tuple[float, ...]


def judge_choices(searches: Sequence[PartSearch]) -> list[JudgedChoice]:
    """The choices of all kinds without the parts that others refute."""
    areas = _explained_areas(searches)
    names = sorted(areas)
    objections = dict.fromkeys(_find_outdone(searches, areas), Objection.OUTDONE)

    def others(k: int, i: int) -> Bools:
        """The pixels of kind `k`'s maps that parts explain which stand, but the `i`-th of them."""
        return _cover_pixels(searches, areas, k, {(k, i), *objections})

    while True:
        ratios = {
            (k, i): _ratio(searches[k], i, others(k, i))
            for k, i in names
            if (k, i) not in objections
        }
        worst = min(ratios, key=lambda name: ratios[name], default=None)
        if worst is not None and ratios[worst] < 0.0:
            objections[worst] = Objection.UNKNOWN
            continue
        ending: dict[tuple[int, int], Objection] = {
            (k, i): Objection.GOES_ON
            for k, i in ratios
            if not has_visible_boundary(
                searches[k].depth_map,
                searches[k].surface,
                searches[k].choice.chosen[i].pose,
                searches[k].tolerance,
                others(k, i),
                least=searches[k].least_ends,
                # Cameras that smooth, and points drawn between others, make steps even.
                most_bent=1.0 if searches[k].is_loose or searches[k].filled > 1.0 else MOST_BENT,
                eaten=searches[k].eaten,
            )
        }
        if not ending:
            break
        # What goes vouched for others until now: they are asked again without it.
        objections |= ending
    return [
        JudgedChoice(
            without(search.choice, {i: why for (j, i), why in objections.items() if j == k}),
            tuple(ratio for (j, _), ratio in ratios.items() if j == k),
        )
        for k, search in enumerate(searches)
    ]


def _find_outdone(
    searches: Sequence[PartSearch], areas: Mapping[tuple[int, int], Mapping[int, np.ndarray]]
) -> list[tuple[int, int]]:
    """Parts in whose place one of another kind stands for which more speaks, by kind and number.

    Two kinds that are nearly alike explain the same surface, and each vouches for the other: what
    the scan says against the larger one would count against neither.
    """
    shared = {
        frozenset((first, other))
        for first, other in combinations(sorted(areas), 2)
        if first[0] != other[0]
        and all(
            _share(areas[first][k], areas[other][k]) > SAME_SURFACE for k in (first[0], other[0])
        )
    }
    evidence = {
        (k, i): searches[k].depth_map.pitch ** 2
        * len(areas[k, i][k])
        * _ratio(searches[k], i, _cover_pixels(searches, areas, k, set().union(*rivals)))
        for k, i in areas
        if (rivals := [pair for pair in shared if (k, i) in pair])
    }
    standing: list[tuple[int, int]] = []
    for name in sorted(evidence, key=lambda name: -evidence[name]):
        if not any(frozenset((name, other)) in shared for other in standing):
            standing.append(name)
    return [name for name in evidence if name not in standing]


def _share(pixels: np.ndarray, others: np.ndarray) -> float:
    """The least share of pixels (n,) and others (m,), by their numbers, that is in both."""
    both = len(np.intersect1d(pixels, others, assume_unique=True))
    return both / max(len(pixels), len(others), 1)


def _ratio(search: PartSearch, i: int, others: Bools) -> float:
    """What speaks for the `i`-th part of a kind [nat]; `others` (pixels,) are explained anyway."""
    return log_likelihood_ratio(
        search.choice.chosen[i].sighting,
        others,
        search.spread,
        search.tolerance,
        is_all_known=True,
        most=search.most,
    )


def _cover_pixels(
    searches: Sequence[PartSearch],
    areas: Mapping[tuple[int, int], Mapping[int, np.ndarray]],
    k: int,
    but: Collection[tuple[int, int]],
) -> Bools:
    """The pixels (pixels,) of kind `k`'s maps that parts explain, but those named."""
    covered = np.zeros(searches[k].depth_map.depth.size, np.bool_)
    for name, pixels in areas.items():
        if name not in but:
            covered[pixels[k]] = True
    return covered


def doubted_apart(search: PartSearch) -> tuple[PartSearch, list[Hypothesis]]:
    """The search without the parts that are in doubt, and their poses.

    A vote that looks at few points may miss the pose that is right; a part that took its place
    would hide it from all later votes.
    """
    chosen = search.choice.chosen
    kept = [looked_through(p.sighting) <= DOUBTED * len(p.sighting.explained) for p in chosen]
    doubted = [
        Hypothesis(part.pose, part.sighting)
        for part, is_kept in zip(chosen, kept, strict=True)
        if not is_kept
    ]
    return replace(search, choice=_keep_only(search.choice, kept)), doubted


def taken_by_others(searches: Sequence[PartSearch]) -> list[Bools]:
    """For each kind, which pixels of its maps standing parts of other kinds explain.

    Returns:
        For each kind (pixels,), no unit.
    """
    taken = [np.zeros(search.depth_map.depth.size, np.bool_) for search in searches]
    if len(searches) == 1:
        return taken
    there = [search for search in searches if search.choice.chosen]
    for other, standing in zip(there, judge_choices(there), strict=True):
        for search, pixels in zip(searches, taken, strict=True):
            if search is not other:
                for part in standing.choice.chosen:
                    pixels[
                        look(search.depth_map, other.surface, part.pose, other.tolerance).explained
                    ] = True
    return taken


def _explained_areas(
    searches: Sequence[PartSearch],
) -> dict[tuple[int, int], dict[int, np.ndarray]]:
    """For each part chosen, by kind and number, the pixels it explains in the maps of each kind.

    Kinds of which nothing was chosen are left out: most of a library.
    """
    chosen_kinds = [k for k, search in enumerate(searches) if search.choice.chosen]
    return {
        (k, i): {
            j: chosen.sighting.explained
            if j == k
            else look(
                searches[j].depth_map, searches[k].surface, chosen.pose, searches[k].tolerance
            ).explained
            for j in chosen_kinds
        }
        for k in chosen_kinds
        for i, chosen in enumerate(searches[k].choice.chosen)
    }


def without(choice: Choice, objections: Mapping[int, Objection]) -> Choice:
    """The choice without its parts, by their number, that have an objection."""
    left = _keep_only(choice, [i not in objections for i in range(len(choice.chosen))])
    left.rejected += [
        Rejection(choice.chosen[i].pose, choice.chosen[i].sighting, why)
        for i, why in sorted(objections.items())
    ]
    return left


def _keep_only(choice: Choice, kept: Sequence[bool]) -> Choice:
    """The choice with only those of its parts that `kept` marks."""
    place = np.where(kept, np.cumsum(kept, dtype=np.int64) - 1, -1)
    rejected = [
        rejection
        if rejection.rival is None
        else replace(rejection, rival=int(place[rejection.rival]))
        if kept[rejection.rival]
        else replace(rejection, reason=Objection.RIVAL_FELL, rival=None)
        for rejection in choice.rejected
    ]
    chosen = [
        assessment for assessment, is_kept in zip(choice.chosen, kept, strict=True) if is_kept
    ]
    claimed = np.where(choice.claimed >= 0, np.append(place, -1)[choice.claimed], -1)
    return Choice(claimed, chosen, rejected)
