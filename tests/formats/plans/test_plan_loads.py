"""Loads in the file of a plan: they come back with the digest, and loads that cannot be do not."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from workbench.formats.plans.plan_files import read_plan, write_plan
from workbench.model.errors import FileError
from workbench.model.load import Load, Loads

LOADS = Loads(
    Load(0.23, np.array([0.0082, 0.0117, 0.052]), np.diag([0.00021, 0.00024, 0.00009])),
    Load(
        0.12,
        np.array([0.0, 0.001, 0.141]),
        np.array([[4e-5, 1e-6, 0], [1e-6, 3e-5, 0], [0, 0, 5e-5]]),
    ),
)


@pytest.fixture
def loaded(plan):
    right, left = plan.arms
    return replace(plan, arms=(replace(right, loads=LOADS), left))


def test_loads_come_back_and_are_in_the_digest(loaded, plan, tmp_path):
    write_plan(tmp_path / "plan.json", loaded)
    found, stated = read_plan(tmp_path / "plan.json")
    assert found.digest == stated == loaded.digest != plan.digest
    right, left = found.arms
    assert left.loads is None
    for mine, theirs in ((LOADS.tool, right.loads.tool), (LOADS.part, right.loads.part)):
        assert theirs.mass == mine.mass
        assert np.array_equal(theirs.centre, mine.centre)
        assert np.array_equal(theirs.inertia, mine.inertia)


def test_a_plan_without_loads_has_no_key_of_them(plan, tmp_path):
    write_plan(tmp_path / "plan.json", plan)
    assert "loads" not in (tmp_path / "plan.json").read_text()


@pytest.mark.parametrize(
    ("change", "why"),
    [
        (lambda loads: loads["tool"].update(mass=0), r"arms\[1\]\.loads\.tool\.mass"),
        (lambda loads: loads["tool"].update(mass=-0.2), r"loads\.tool\.mass"),
        (lambda loads: loads["tool"].update(mass=math.nan), "NaN"),
        (lambda loads: loads["part"].update(centre=[0, 0]), r"loads\.part\.centre: 3 numbers"),
        (lambda loads: loads["part"].update(inertia=[[1, 0, 0]]), r"loads\.part\.inertia"),
        (
            lambda loads: loads["part"]["inertia"][0].__setitem__(0, -1e-5),
            "no body has its inertia",
        ),
        (lambda loads: loads["part"]["inertia"][0].__setitem__(1, 2e-5), "not symmetric"),
        (lambda loads: loads["part"]["inertia"][2].__setitem__(2, 1e-3), "sum of the others"),
        (lambda loads: loads.pop("part"), r"loads\.part: is missing"),
        (lambda loads: loads["tool"].update(weight=1), "weight: is not known here"),
    ],
)
def test_a_load_that_cannot_be_is_refused_by_its_key(loaded, tmp_path, change, why):
    write_plan(tmp_path / "plan.json", loaded)
    content = json.loads((tmp_path / "plan.json").read_text())
    change(content["arms"][0]["loads"])
    (tmp_path / "plan.json").write_text(json.dumps(content))
    with pytest.raises(FileError, match=why):
        read_plan(tmp_path / "plan.json")
