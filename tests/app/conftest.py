"""The small cell and its values that all these tests share."""

from idle import idle  # noqa: F401
from samples import cell, in_rows, make_cell, samples  # noqa: F401
