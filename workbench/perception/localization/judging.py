"""Which of all that was found stands: what is left when the parts of all kinds are held together.

A part that hides half of another one speaks for neither while it is not known itself, so this comes
last.  What something unknown explains better goes, the worst first, since parts vouch for each
other; then what does not end where it should.  The rest is asked again, until nothing goes.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from workbench.model.geometry import Bools, Floats
from workbench.model.part import Part
from workbench.model.scan import Objection
from workbench.perception.localization.choice import Choice, Rejection
from workbench.perception.localization.likelihood import log_likelihood_ratio
from workbench.perception.localization.maps import DepthMap
from workbench.perception.localization.outline import ends_there
from workbench.perception.localization.sightings import look
from workbench.perception.parts.part_surface import PartSurface


@dataclass(frozen=True, slots=True, eq=False)
class Sought:
    """What the search for one part has taken so far.

    `maps` are those of the scan for this part, `glance` the same, coarser; `tolerance` [m] see
    `sightings.look`, `spread` [m] see `likelihood`.  `are_possible` says which of poses (k, 4, 4)
    may be at all, (k,).
    """

    part: Part
    surface: PartSurface
    maps: DepthMap
    glance: DepthMap
    tolerance: float
    spread: float
    are_possible: Callable[[Floats], Bools]
    choice: Choice


@dataclass(frozen=True, slots=True, eq=False)
class Judged:
    """A choice without what does not stand, and the log likelihood ratio [nat] of what does."""

    choice: Choice
    ratios: tuple[float, ...]


def judged(brought: Sequence[Sought]) -> list[Judged]:
    """The choices of all kinds without what does not stand beside the others."""
    objections: dict[tuple[int, int], Objection] = {}
    areas = _areas(brought)
    names = sorted(areas)

    def others(k: int, i: int) -> Bools:
        """The pixels of kind `k`'s maps that parts explain which stand, but the `i`-th of them."""
        covered = np.zeros(brought[k].maps.depth.size, np.bool_)
        for name in names:
            if name != (k, i) and name not in objections:
                covered[areas[name][k]] = True
        return covered

    while True:
        ratios = {
            (k, i): log_likelihood_ratio(
                brought[k].choice.chosen[i].sighting,
                others(k, i),
                brought[k].spread,
                brought[k].tolerance,
                is_all_known=True,
            )
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
            if not ends_there(
                brought[k].maps,
                brought[k].surface,
                brought[k].choice.chosen[i].pose,
                brought[k].tolerance,
                others(k, i),
            )
        }
        if not ending:
            break
        # What goes vouched for others until now: they are asked again without it.
        objections |= ending
    return [
        Judged(
            without(one.choice, {i: why for (j, i), why in objections.items() if j == k}),
            tuple(ratio for (j, _), ratio in ratios.items() if j == k),
        )
        for k, one in enumerate(brought)
    ]


def taken_by_others(brought: Sequence[Sought]) -> list[Bools]:
    """For each kind, which pixels of its maps standing parts of other kinds explain.

    Returns:
        For each kind (pixels,), no unit.
    """
    taken = [np.zeros(one.maps.depth.size, np.bool_) for one in brought]
    if len(brought) == 1:
        return taken
    there = [one for one in brought if one.choice.chosen]
    for other, standing in zip(there, judged(there), strict=True):
        for one, pixels in zip(brought, taken, strict=True):
            if one is not other:
                for part in standing.choice.chosen:
                    pixels[look(one.maps, other.surface, part.pose, other.tolerance).explained] = (
                        True
                    )
    return taken


def _areas(brought: Sequence[Sought]) -> dict[tuple[int, int], list[np.ndarray]]:
    """For each part chosen, by kind and number, the pixels it explains in the maps of each kind."""
    return {
        (k, i): [
            chosen.sighting.explained
            if j == k
            else look(other.maps, one.surface, chosen.pose, one.tolerance).explained
            for j, other in enumerate(brought)
        ]
        for k, one in enumerate(brought)
        for i, chosen in enumerate(one.choice.chosen)
    }


def without(choice: Choice, objections: Mapping[int, Objection]) -> Choice:
    """The choice without those of its parts, by their number, that something is said against."""
    kept = [i not in objections for i in range(len(choice.chosen))]
    place = np.where(kept, np.cumsum(kept) - 1, -1)
    rejected = [
        one
        if one.rival is None
        else replace(one, rival=int(place[one.rival]))
        if kept[one.rival]
        else replace(one, reason=Objection.RIVAL_FELL, rival=None)
        for one in choice.rejected
    ]
    rejected += [
        Rejection(choice.chosen[i].pose, choice.chosen[i].sighting, why)
        for i, why in sorted(objections.items())
    ]
    chosen = [one for i, one in enumerate(choice.chosen) if kept[i]]
    claimed = np.where(choice.claimed >= 0, np.append(place, -1)[choice.claimed], -1)
    return Choice(claimed, chosen, rejected)
