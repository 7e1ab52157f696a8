"""A recipe: what belongs together when a cell picks parts of a kind, or fills kits."""

from dataclasses import dataclass, field

from workbench.model.digest import LATER
from workbench.model.recipes.kit import KitItem

NO_RECIPE = 0
"""The number that stands for none: the cell is as its file states it."""

MOST_RECIPES = 100

HIGHEST_NUMBER = 65_535
"""The largest number of a recipe: a PLC holds it in a word."""


@dataclass(frozen=True, slots=True)
class Recipe:
    """What a cell picks, how, and to where; what is empty or None is as the cell has it.

    `number` is from 1 to `HIGHEST_NUMBER`.  `parts` are the kinds that are searched for and taken.
    `grasps` are names of entries of their libraries, and `places` names of the arms' places.  A
    planning for which nobody names a strategy takes `strategy`.  `threshold` [m] and `speed`, a
    share of the joints' speeds, replace those of the policy.

    Where there are `items`, parts are taken as long as a kit of these lacks them.  `in_order`:
    those of an item only when the items before it are complete.  Parts are taken from `bin`.
    """

    number: int
    name: str
    parts: tuple[str, ...] = ()
    grasps: tuple[str, ...] = ()
    places: tuple[str, ...] = ()
    strategy: str = ""
    threshold: float | None = None
    speed: float | None = None
    items: tuple[KitItem, ...] = field(default=(), metadata=LATER)
    in_order: bool = field(default=False, metadata=LATER)
    bin: str = field(default="", metadata=LATER)


def names_of(places: int, names: tuple[str, ...]) -> tuple[str, ...]:
    """As many names as there are places, empty for those that nobody has named."""
    return (*names, *[""] * places)[:places]
