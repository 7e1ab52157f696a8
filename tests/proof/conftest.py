"""Proofs are tried on a plan for two parts, both of them by the same tests."""

import pytest
from proving import by_first, by_second
from two_parts import cell, lying, result, world

__all__ = ["cell", "result", "world"]


@pytest.fixture(scope="session")
def detections(cell):
    """Nothing of them is in the floor."""
    return lying(cell, 0.0191)


@pytest.fixture(params=["first", "second"])
def proof_of(request):
    """The proof of a plan that is taken at its word for what is in the bin, by both proofs."""
    return by_first if request.param == "first" else by_second
