"""Planning is tried on a cell with two parts in its bin."""

import pytest
from two_parts import cell, lying, result, world

__all__ = ["cell", "result", "world"]


@pytest.fixture(scope="session")
def detections(cell):
    """Their bodies are on the floor, so their collars reach 2.5 mm into it."""
    return lying(cell, 0.0165)
