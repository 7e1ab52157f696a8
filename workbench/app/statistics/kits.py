"""Kits that were taken away, by the recipe that says what belongs in them."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, slots=True)
class KitCount:
    """Kits by the recipe of that number: `complete` had all their parts, `incomplete` had not."""

    recipe: int
    complete: int
    incomplete: int

    def __add__(self, other: "KitCount") -> "KitCount":
        """Both together, by the recipe of the first."""
        return KitCount(
            self.recipe, self.complete + other.complete, self.incomplete + other.incomplete
        )


def add_kits(*several: Iterable[KitCount]) -> tuple[KitCount, ...]:
    """All of them together, one for each recipe, in the order of their numbers."""
    sums: dict[int, KitCount] = {}
    for counts in several:
        for count in counts:
            sums[count.recipe] = sums.get(count.recipe, KitCount(count.recipe, 0, 0)) + count
    return tuple(sums[recipe] for recipe in sorted(sums))


class Kits:
    """Counts kits, entry after entry.

    Concurrency: one thread.
    """

    def __init__(self) -> None:
        self.value: tuple[KitCount, ...] = ()
        self._last = KitCount(0, 0, 0)

    def add(self, after: Mapping[str, Any]) -> None:
        """Take in the state after a new kit was begun; it counts since the recipe was chosen."""
        kit = after["kit"]
        now = KitCount(kit["recipe"], kit["complete"], kit["incomplete"])
        is_first = now.complete + now.incomplete == 1
        is_complete = now.complete > (0 if is_first else self._last.complete)
        one = KitCount(now.recipe, int(is_complete), int(not is_complete))
        self.value, self._last = add_kits(self.value, [one]), now
