"""Average precisions as BOP has them, in a table."""

from collections.abc import Mapping
from typing import Any

BOP_ERRORS = ("mssd", "mssd_mm", "mspd", "bop24")
BOP_COLUMNS = ("AP MSSD", "AP MSSD mm", "AP MSPD", "AP")


def bop_words(figures: Mapping[str, Any]) -> tuple[str, ...]:
    """The average precisions, as a table has them."""
    values = (figures.get(name) for name in BOP_ERRORS)
    return tuple("" if value is None else f"{value:.3f}" for value in values)
