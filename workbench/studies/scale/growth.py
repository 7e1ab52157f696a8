"""What a step costs at several sizes, and the exponent by which the cost grows."""

import ctypes
import gc
import math
import re
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from statistics import median

MOST_REPEATS = 3
"""A short step is measured this often."""

LONG_SECONDS = 5.0
"""[s] A step that takes longer is measured once."""

Costs = Mapping[str, float]
"""What each step costs at one size, by the step's name, which ends in its unit."""


@dataclass(frozen=True, slots=True)
class Growth:
    """What one step costs at several sizes.

    Attributes:
        subject: what is counted, as "kinds of parts".
        step: its name, which ends in the unit of the costs.
        sizes: the counts, ascending.
        costs: at each size.
    """

    subject: str
    step: str
    sizes: tuple[int, ...]
    costs: tuple[float, ...]

    @property
    def exponents(self) -> tuple[float, ...]:
        """From each size to the next: 1 is linear, 2 quadratic; NaN where a cost is 0."""
        points = list(zip(self.sizes, self.costs, strict=True))
        return tuple(
            math.log(after / before) / math.log(larger / smaller)
            if before > 0 and after > 0
            else math.nan
            for (smaller, before), (larger, after) in pairwise(points)
        )


def growths(subject: str, by_size: Mapping[int, Costs]) -> tuple[Growth, ...]:
    """The growth of each step that was measured at every size, in the order of the steps."""
    sizes = tuple(sorted(by_size))
    return tuple(
        Growth(subject, step, sizes, tuple(by_size[size][step] for size in sizes))
        for step in by_size[sizes[0]]
        if all(step in by_size[size] for size in sizes)
    )


def processor_seconds(step: Callable[[], object]) -> float:
    """The median processor time [s] that a step takes of this process, all threads together."""
    times: list[float] = []
    while len(times) < MOST_REPEATS and sum(times) < LONG_SECONDS:
        began = time.process_time()
        step()
        times.append(time.process_time() - began)
    return median(times)


def seconds_and_megabytes(step: Callable[[], object]) -> tuple[float, float]:
    """Processor time [s] of a step, and how far resident memory rises meanwhile [MB] (glibc)."""
    gc.collect()
    ctypes.CDLL(None).malloc_trim(0)
    # Resets the peak (proc_pid_clear_refs(5)).
    Path("/proc/self/clear_refs").write_text("5")
    before, began = _resident("VmRSS"), time.process_time()
    step()
    return time.process_time() - began, max(0.0, _resident("VmHWM") - before)


def _resident(key: str) -> float:
    found = re.search(rf"{key}:\s+(\d+) kB", Path("/proc/self/status").read_text())
    return 0.0 if found is None else int(found[1]) / 1024


def form(growth: Growth) -> dict[str, object]:
    """A growth for JSON."""
    exponents: Sequence[float | None] = [
        None if math.isnan(exponent) else round(exponent, 2) for exponent in growth.exponents
    ]
    return {
        "subject": growth.subject,
        "step": growth.step,
        "sizes": list(growth.sizes),
        "costs": [float(f"{cost:.4g}") for cost in growth.costs],
        "exponents": exponents,
    }
