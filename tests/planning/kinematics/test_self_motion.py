"""Self-motion: the tool stays, the arm moves, the limits hold."""

import numpy as np
import pytest

from workbench.formats.cells.reading import read_cell
from workbench.planning.kinematics.chain import chain_of
from workbench.planning.kinematics.self_motion import self_motion


@pytest.mark.parametrize("arm", ["right", "left"])
def test_the_tool_stays_while_the_elbow_turns(arm):
    cell = read_cell("yumi")
    chain, home = chain_of(cell, cell.arm(arm)), np.asarray(cell.arm(arm).home)
    found = self_motion(chain, home)
    assert len(found) > 10
    assert any(np.array_equal(q, home) for q in found)
    T = chain.pose(home)
    for q in found:
        assert np.all((q >= chain.lower) & (q <= chain.upper))
        assert T.isApprox(chain.pose(q), 1e-4)
    steps = np.linalg.norm(np.diff(found, axis=0), axis=1)
    assert np.all((steps > 0.04) & (steps < 0.3))


def test_six_axes_have_nothing_to_spare():
    cell = read_cell("tx2_90")
    home = np.asarray(cell.arms[0].home)
    assert np.array_equal(self_motion(chain_of(cell, cell.arms[0]), home), home[None])
