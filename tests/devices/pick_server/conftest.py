"""What tests of this link share."""

import pytest
from pick_scenes import approved


@pytest.fixture(scope="session")
def planned():
    """A cell whose robot program asks, a plan, and its approval."""
    return approved()
