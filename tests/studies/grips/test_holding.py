"""Whether what is said of grips and what MuJoCo does with them agree, on few grips."""

from dataclasses import replace

import pytest

from workbench.studies.grips.holding import Case, Pulled, pull_all, summary


def one(share: float, stayed: bool) -> Pulled:
    return Pulled("bolt", 0, share, True, stayed)


def test_disagreements_are_counted_each_by_its_kind():
    told = summary([one(3.0, True), one(0.3, False), one(1.5, False), one(0.9, True)])
    assert told["all"] == {
        "grips": 4,
        "stayed": 2,
        "agreement": 0.5,
        "said_to_hold": 2,
        "false_holds": 1,
        "false_slips": 1,
    }
    assert told["near"]["grips"] == 2 and told["false_holds"] == [(1.5, "bolt", 0)]
    assert summary([])["all"]["agreement"] is None


@pytest.fixture(scope="module")
def some():
    return [pull_all(Case("yumi", "bracket", seed)) for seed in range(8)]


def test_most_grips_do_as_said_and_the_same_again(some):
    told = summary([one for one in some if one is not None])["all"]
    assert told["grips"] >= 6 and 0 < told["stayed"] < told["grips"]
    assert told["agreement"] >= 0.7
    assert pull_all(Case("yumi", "bracket", 3)) == some[3]


def test_what_pulls_harder_takes_the_part_along(some):
    """The mass goes with what friction holds, so that a weak hand is given a light part."""
    stayed = next(one for one in some if one is not None and one.stayed)
    weak = pull_all(replace(Case("yumi", "bracket", stayed.seed), force=2.0))
    assert weak is not None and weak.share == pytest.approx(stayed.share, rel=1e-6)


def test_a_cup_lets_go_of_what_is_too_heavy():
    found = [pull_all(Case("tx2_90", "puck", seed)) for seed in range(6)]
    told = summary([one for one in found if one is not None])["all"]
    assert told["grips"] >= 4 and 0 < told["stayed"] < told["grips"]
    assert told["false_holds"] == 0
