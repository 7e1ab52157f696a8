"""What `import workbench` offers to programs."""

import inspect
import subprocess
import sys

import pytest

import workbench
from workbench import api


def test_the_package_offers_what_its_interface_names_and_nothing_else():
    assert workbench.__all__ == sorted(api.__all__, key=lambda name: (name[0].islower(), name))
    for name in workbench.__all__:
        assert getattr(workbench, name) is getattr(api, name)
        assert name in dir(workbench)
    with pytest.raises(AttributeError, match="has no attribute 'plane'"):
        workbench.plane  # noqa: B018


@pytest.mark.parametrize("name", api.__all__)
def test_everything_says_what_it_is(name):
    assert inspect.getdoc(getattr(api, name))


def test_nothing_heavy_is_loaded_before_it_is_used():
    code = "import sys, workbench; print([n for n in ('numpy', 'pinocchio') if n in sys.modules])"
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert said.stdout == "[]\n"


def test_a_changed_plan_is_not_read(tmp_path, monkeypatch):
    cell = workbench.read_cell("yumi")
    pile = workbench.drop_parts([cell.parts[0]] * 2, cell.bin, seed=3)
    plan = workbench.plan(cell, pile).plan
    file = tmp_path / "plan.json"
    workbench.write_plan(file, plan)
    assert workbench.read_plan(file).digest == plan.digest
    file.write_text(file.read_text().replace('"seed": 0', '"seed": 1'))
    with pytest.raises(workbench.FileError, match="was changed after it was made"):
        workbench.read_plan(file)
