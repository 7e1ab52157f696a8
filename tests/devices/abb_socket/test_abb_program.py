"""Plans that do not fit into a controller's program."""

from dataclasses import replace

import numpy as np
import pytest

from workbench.devices.abb_socket.program import program_of
from workbench.model.errors import InputError


def test_a_program_that_is_too_long_is_not_sent(cell, plan, approval):
    one = plan.arms[0]
    legs = tuple(
        replace(leg, q=np.repeat(leg.q, 50, axis=0), t=np.arange(len(leg.q) * 50) * 1.0)
        for leg in one.legs
    )
    with pytest.raises(InputError, match="a controller has room for 400"):
        program_of(cell, replace(plan, arms=(replace(one, legs=legs), plan.arms[1])), approval)


def test_a_program_that_is_too_slow_is_not_sent(cell, plan, approval):
    one = plan.arms[0]
    legs = (replace(one.legs[0], t=one.legs[0].t * 1e4), *one.legs[1:])
    with pytest.raises(InputError, match=rf"leg reach of arm {one.arm} takes .* s from one"):
        program_of(cell, replace(plan, arms=(replace(one, legs=legs), plan.arms[1])), approval)
