"""Plans of parts of many sizes, and over a station, bent by chance: no bent one is let through."""

from itertools import islice

import pytest
from bending_machine import bends, good_cases

from workbench.model.scan import Detection, Scene


@pytest.mark.parametrize("name", ["regrasp", "plate_300", "bar_400", "cube_20", "rod_180"])
def test_no_bent_plan_is_let_through(name, tmp_path):
    said = list(islice(bends(name, 11, tmp_path, 12), 12))
    assert [one for one in said if one["outcome"] == "let through"] == []
    assert {one["outcome"] for one in said} == {"refused", "harmless"}


def test_both_plans_of_a_row_are_bent(tmp_path):
    first, second = good_cases("regrasp", 11, tmp_path)
    assert first.plan.stations and not second.plan.stations
    assert any(isinstance(one, Detection) and one.T_world_found for one in second.scene.detections)
    assert isinstance(second.scene, Scene)
