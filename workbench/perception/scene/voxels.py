"""Points counted in small cubes: a cloud is thinned by its density, whatever its number."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from workbench.model.geometry import Bools, Floats, Ints

_BITS = 21
_HALF = 1 << (_BITS - 1)
_STEPS = np.stack(np.meshgrid(*[[-1, 0, 1]] * 3, indexing="ij"), axis=-1).reshape(-1, 3)


@dataclass(frozen=True, slots=True, eq=False)
class Voxels:
    """Cubes that hold points: whole-numbered places `index` (n, 3), and how many points, (n,).

    A cube reaches from `index * edge` to `(index + 1) * edge` [m] along each axis.
    """

    index: Ints
    counts: Ints
    edge: float

    @property
    def centres(self) -> Floats:
        """The middle (n, 3) [m] of each cube."""
        middles: Any = self.index + 0.5
        return middles * self.edge

    def only(self, chosen: Bools) -> "Voxels":
        """Those of the cubes that are `chosen` (n,)."""
        return Voxels(self.index[chosen], self.counts[chosen], self.edge)


def counted(points: Floats, edge: float) -> Voxels:
    """The cubes of a grid that hold points (n, 3) [m], each within a million edges of zero."""
    keys, counts = np.unique(_keys(np.floor(points / edge).astype(np.int64)), return_counts=True)
    return Voxels(_places(keys), counts, edge)


class Blocks:
    """Groups of voxels, `width` along each axis, which are asked together with their neighbours."""

    def __init__(self, voxels: Voxels, width: int):
        self._keys, self._of_voxel = np.unique(_keys(voxels.index // width), return_inverse=True)
        places = _places(self._keys)
        around = [np.searchsorted(self._keys, _keys(places + step)) for step in _STEPS]
        last = len(self._keys) - 1
        self._around = [np.minimum(found, last) for found in around]
        self._is_there = [
            self._keys[found] == _keys(places + step)
            for found, step in zip(self._around, _STEPS, strict=True)
        ]

    def sums(self, weights: Ints | Bools) -> Floats:
        """What the voxels of each one's block and of the 26 around it weigh: (n,), no unit."""
        own = np.bincount(self._of_voxel, weights, minlength=len(self._keys))
        total = np.zeros(len(self._keys))
        for found, is_there in zip(self._around, self._is_there, strict=True):
            total += np.where(is_there, own[found], 0.0)
        return total[self._of_voxel]


def _keys(index: Ints) -> Ints:
    """One whole number (n,) for each place (n, 3)."""
    shifted = index + _HALF
    return (shifted[:, 0] << 2 * _BITS) | (shifted[:, 1] << _BITS) | shifted[:, 2]


def _places(keys: Ints) -> Ints:
    mask = (1 << _BITS) - 1
    return np.stack([keys >> 2 * _BITS, keys >> _BITS & mask, keys & mask], axis=1) - _HALF
