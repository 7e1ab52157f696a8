"""A conversation that has not begun."""

import pytest
from abb_talk import Talk


@pytest.fixture
def talk(cell, plan, approval):
    return Talk(cell, plan, approval)
