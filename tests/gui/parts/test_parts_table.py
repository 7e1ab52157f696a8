"""The table of the parts found: what each row tells."""

import re

import numpy as np

from workbench.gui.parts.views import parts_html
from workbench.model.geometry import pose_from_rpy
from workbench.model.scan import Detection

EVIL = "<b>bolt</b>"


def test_parts_say_how_sure_they_are_where_it_is_known():
    T = pose_from_rpy((0, 0, 0))
    variances = np.diag([1e-8, 4e-8, 1e-8, 1e-5, 1e-5, 4e-5])
    sure = Detection("bolt", T, residual=1e-4, covariance=variances, probability=0.93)
    html = parts_html((sure, Detection(EVIL, T)), 0, ("a", "b"))
    text = re.sub(r"<[^>]*>", " ", html)
    for word in ("Sure", "93%", "0.20 mm 0.4°", "by hand", "&lt;b&gt;bolt"):
        assert word in text
    assert EVIL not in html and text.count("°") == 1
