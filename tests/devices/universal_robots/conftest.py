"""What tests of this link share."""

import pytest
from twins import own_host


@pytest.fixture
def host() -> str:
    """An address of this machine that no other test has: the client chooses no ports."""
    return own_host()
