"""LZF, by which compressed PCD files are packed: runs of bytes, and copies of what came before.

Source: the format as liblzf (M. Lehmann, 2-clause BSD) writes it and Point Cloud Library reads it.
"""

import numpy as np
from numba import njit


@njit(cache=True)
def unpack(packed: np.ndarray, out: np.ndarray) -> int:
    """Unpack LZF data.

    Args:
        packed: (n,) bytes as uint8.
        out: (m,) uint8, written from its start.

    Returns:
        How many bytes were written, -1 when the data is broken or has no room.
    """
    at, to = 0, 0
    while at < len(packed):
        control = int(packed[at])
        at += 1
        if control < 32:
            length = control + 1
            if at + length > len(packed) or to + length > len(out):
                return -1
            for k in range(length):
                out[to + k] = packed[at + k]
            at, to = at + length, to + length
            continue
        length = control >> 5
        if length == 7:
            if at >= len(packed):
                return -1
            length += int(packed[at])
            at += 1
        if at >= len(packed):
            return -1
        source = to - ((control & 31) << 8) - int(packed[at]) - 1
        at += 1
        length += 2
        if source < 0 or to + length > len(out):
            return -1
        for k in range(length):
            out[to + k] = out[source + k]
        to += length
    return to
