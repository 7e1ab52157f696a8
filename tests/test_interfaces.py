"""What others rely on stays: `docs/stability.md` promises it.

`WORKBENCH_GOLDEN=write pytest tests/test_interfaces.py` records what there is now.
"""

import json
import os

import pytest
from interfaces import FILE, broken, interfaces


@pytest.fixture(scope="module")
def now():
    return interfaces()


@pytest.fixture(scope="module")
def recorded(now):
    if os.environ.get("WORKBENCH_GOLDEN") == "write":
        FILE.write_text(json.dumps(now, indent=0, ensure_ascii=False) + "\n", encoding="utf-8")
    return json.loads(FILE.read_text(encoding="utf-8"))


def test_nothing_is_lost_and_nothing_more_is_asked_for(recorded, now):
    assert broken(recorded, now) == []


def test_what_is_new_is_recorded(recorded, now):
    new = {
        name: [f for f in facts if f not in recorded.get(name, ())] for name, facts in now.items()
    }
    assert not any(new.values()), new


@pytest.mark.parametrize(
    ("before", "after", "says"),
    [
        ("get /state has phase", None, "HTTP: get /state has phase"),
        ("post /scan takes seed", "post /scan takes seed needed", "post /scan takes seed"),
        (None, "post /scan takes weather needed", "post /scan takes weather needed"),
    ],
)
def test_a_field_that_goes_or_is_needed_now_is_found(recorded, before, after, says):
    facts = [fact for fact in recorded["HTTP"] if fact != before] + ([after] if after else [])
    found = broken(recorded, {**recorded, "HTTP": facts})
    assert found and says in found[0]


def test_what_comes_along_breaks_nothing(recorded):
    more = [
        *recorded["HTTP"],
        "post /scan takes weather",
        "post /sky",
        "post /sky takes cloud needed",
    ]
    assert broken(recorded, {**recorded, "HTTP": more}) == []


def test_each_interface_has_facts(recorded):
    assert all(len(facts) > 5 for facts in recorded.values())
