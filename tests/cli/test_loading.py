import gc
import subprocess
import sys

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


def test_what_was_loaded_is_not_searched_for_garbage():
    before = gc.get_freeze_count()
    try:
        with loading():
            pass
        assert gc.get_freeze_count() > before
    finally:
        gc.unfreeze()


@pytest.mark.parametrize("module", ["planning", "look"])
def test_planning_and_searching_begin_without_what_they_need_later_or_never(module: str):
    code = (
        f"import sys, workbench.cli.picking.{module}\n"
        "heavy = {'open3d', 'mujoco', 'trimesh', 'scipy.spatial', 'scipy.optimize'}\n"
        "print(sorted(heavy & set(sys.modules)))"
    )
    ended = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=600, check=True
    )
    assert ended.stdout.splitlines()[-1] == "[]"
