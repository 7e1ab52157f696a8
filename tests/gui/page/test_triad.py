"""The axes of the world in a corner of the scene."""

import re
from types import SimpleNamespace

import numpy as np
import pinocchio as pin

from workbench.gui.page.triad import Triad, triad_html


def turn_of(right, away):
    """The turn of a camera by where its right and its look lead in the world."""
    R = np.stack([right, np.cross(away, right), away], axis=1)
    q = pin.Quaternion(R)
    return np.array([q.w, q.x, q.y, q.z])


def ends(html):
    """The end of each axis [px] by its letter, in the order drawn."""
    lines = re.findall(r'x2="(\S+)" y2="(\S+)".*?>([xyz])<', html)
    return {name: (float(x), float(y)) for x, y, name in lines}


def test_from_in_front_z_leads_up_and_what_is_near_is_drawn_last():
    seen = ends(triad_html(turn_of(np.array([1.0, 0, 0]), np.array([0, 1.0, 0]))))
    assert seen["x"] == (18.0, 0.0) and seen["z"] == (0.0, -18.0)
    np.testing.assert_allclose(seen["y"], (0.0, 0.0), atol=0.05)
    assert next(iter(seen)) == "y", "it leads away"
    from_behind = ends(triad_html(turn_of(np.array([-1.0, 0, 0]), np.array([0, -1.0, 0]))))
    assert from_behind["x"] == (-18.0, 0.0) and list(from_behind)[-1] == "y"


def test_it_follows_the_camera_once_the_browser_has_said_where_it_is(visitor):
    triad = Triad(visitor)
    triad.show()
    assert triad._html.content == ""
    above = turn_of(np.array([1.0, 0, 0]), np.array([0, 0, -1.0]))
    visitor.client.camera = SimpleNamespace(update_timestamp=1.0, wxyz=above)
    triad.show()
    first = triad._html.content
    assert ends(first)["y"] == (0.0, -18.0)
    visitor.client.camera.wxyz = turn_of(np.array([0, 1.0, 0]), np.array([0, 0, -1.0]))
    triad.show()
    assert triad._html.content != first
