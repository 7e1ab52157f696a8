"""How an arm follows `servoj`, as we read the maker: each joint is steered to its reference."""

from collections.abc import Sequence

import numpy as np

from workbench.devices.universal_robots.urscript import Line

CONTROLLER_CYCLE = 0.002
"""[s] Of the controller."""


class Following:
    """The motion of calls of `servoj` that follow each other, from rest.

    Args:
        start: where the axes are before (6,) [rad].
        lines: `servoj`, at least one.
    """

    def __init__(self, start: Sequence[float], lines: Sequence[Line]) -> None:
        q, speed = np.array(start, dtype=np.float64), np.zeros(len(start))
        passed = [q]
        for line in lines:
            for _ in range(max(round(line.t / CONTROLLER_CYCLE), 1)):
                speed = speed + CONTROLLER_CYCLE * line.gain * (line.q - q - line.lookahead * speed)
                q = q + CONTROLLER_CYCLE * speed
                passed.append(q)
        self._passed = np.array(passed)
        self.seconds: float = (len(passed) - 1) * CONTROLLER_CYCLE

    def at(self, t: float) -> tuple[float, ...]:
        """The axes (6,) [rad] after `t` [s]."""
        step = min(max(t, 0.0) / CONTROLLER_CYCLE, len(self._passed) - 1.0)
        k = min(int(step), len(self._passed) - 2)
        along = step - k
        return tuple(((1 - along) * self._passed[k] + along * self._passed[k + 1]).tolist())
