"""Pairs in groups: of a link with another one, or of a link with something that stands.

What lies on one joint lies in one ball, its hub: a group whose hubs stay apart is done with.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from workbench.model.geometry import Floats, Ints
from workbench.planning.compiled import njit_in_place


class Groups(NamedTuple):
    """Pairs sorted into groups.

    `pairs` (k,) are those of group g from `begins[g]` to `begins[g + 1]`; `margins` (g,) [m] is the
    largest of each; `order` (g,) is that in which groups are checked, `group` (p,) that of every
    pair of the model.
    """

    pairs: Ints
    begins: Ints
    margins: Floats
    order: Ints
    group: Ints


@njit(cache=True)
def groups_of(among: Ints, margins: Floats, first: Ints, second: Ints, joint: Ints) -> Groups:
    """The groups of the pairs `among` (k,), whose bodies are `first` and `second` (p,).

    `margins` (p,) [m] are those of all pairs; `joint` (b,) carries each body.
    """
    bodies = len(joint)
    units = bodies + 1
    for g in range(bodies):
        units = max(units, bodies + joint[g] + 1)
    number = np.full(units * units, -1, np.int64)
    group = np.full(len(first), -1, np.int64)
    found = 0
    for at in range(len(among)):
        k = among[at]
        a, b = first[k], second[k]
        # What stands is a thing of its own, what moves goes with all that is on its joint.
        first_group = a if joint[a] == 0 else bodies + joint[a]
        second_group = b if joint[b] == 0 else bodies + joint[b]
        if number[first_group * units + second_group] < 0:
            number[first_group * units + second_group] = found
            found += 1
        group[k] = number[first_group * units + second_group]
    begins, most = np.zeros(found + 1, np.int64), np.full(found, -1e9)
    for at in range(len(among)):
        k = among[at]
        begins[group[k] + 1] += 1
        most[group[k]] = max(most[group[k]], margins[k])
    for g in range(found):
        begins[g + 1] += begins[g]
    pairs, filled = np.empty(len(among), np.int64), begins.copy()
    for at in range(len(among)):
        k = among[at]
        pairs[filled[group[k]]] = k
        filled[group[k]] += 1
    return Groups(pairs, begins, most, np.arange(found), group)


@njit_in_place
def move_to_front(pair: int, groups: Groups) -> None:
    """Have a pair that touched be the first of its group, and this the first of all."""
    g = groups.group[pair]
    begin = groups.begins[g]
    for at in range(begin, groups.begins[g + 1]):
        if groups.pairs[at] == pair:
            groups.pairs[at] = groups.pairs[begin]
            groups.pairs[begin] = pair
            break
    at = 0
    while groups.order[at] != g:
        at += 1
    for before in range(at, 0, -1):
        groups.order[before] = groups.order[before - 1]
    groups.order[0] = g
