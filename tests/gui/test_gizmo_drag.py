"""A drag that begins somewhere else than the gizmo stands moves nothing, to its end."""

import numpy as np
import pinocchio as pin

from workbench.gui.gizmo_drag import GizmoDrag


def at(*p) -> pin.SE3:
    return pin.SE3(np.eye(3), np.array(p, dtype=float))


def test_a_drag_from_where_the_gizmo_stands_may_go_far():
    drag, here = GizmoDrag(), at(0.41, 0, 0)
    assert drag.is_believed("start", here, here)
    assert drag.is_believed("update", here, at(0.41, 0, 0.01))
    assert drag.is_believed("update", here, at(0.41, 0, 0.5))
    assert drag.is_believed("end", here, at(0.41, 0, 0.5))


def test_a_drag_from_the_origin_is_not_believed_and_the_next_one_may_be():
    drag, here = GizmoDrag(), at(0.41, 0, 0)
    assert drag.is_believed("start", here, here)
    assert not drag.is_believed("update", here, at(0, 0, 0.01))
    assert not drag.is_believed("update", here, at(0.41, 0, 0.01))
    assert not drag.is_believed("end", here, at(0, 0, 0.07))
    assert drag.is_believed("start", here, here)
    assert drag.is_believed("update", here, at(0.4, 0, 0))
