"""One plan for all tests of EGM."""

import pytest


@pytest.fixture(scope="session")
def planned():
    from egm_scenes import plan_of_two

    return plan_of_two()
