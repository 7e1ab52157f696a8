import gc

import pytest

from workbench.cli.loading import loading


def test_garbage_is_looked_for_again_after_loading_even_if_that_fails():
    with pytest.raises(ValueError), loading():
        assert not gc.isenabled()
        raise ValueError
    assert gc.isenabled()


def test_loading_within_loading_leaves_garbage_alone_until_the_outer_one_ends():
    with loading():
        with loading():
            pass
        assert not gc.isenabled()
    assert gc.isenabled()
