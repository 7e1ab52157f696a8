"""The axis of an unknown roll is checked wherever a detection comes from."""

import numpy as np
import pinocchio as pin
import pytest

from workbench.model.errors import InputError
from workbench.model.scan import Detection


@pytest.mark.parametrize(
    "axis",
    [
        [[0, 0, 0], [0, 0, 0.5]],
        [[0, 0, 0], [0, 0, 0]],
        [[0, 0, 0], [0, 0, np.nan]],
        [[0, np.inf, 0], [0, 0, 1]],
        [[0, 0, 1]],
    ],
)
def test_what_is_no_axis_is_refused(axis):
    with pytest.raises(InputError, match="the axis of a roll"):
        Detection("peg", pin.SE3.Identity(), roll_known=False, roll_axis=np.array(axis, float))
