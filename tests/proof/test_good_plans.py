"""Plans of the studies hold, and the judge finds nothing in them: a sample of `judge_studies`."""

import pytest
from judge import Judge
from judge_studies import FULL_BINS, cell_and_files, of_emptying, of_threshold, refused


@pytest.mark.parametrize("seed", [0, 41, 47])
def test_plans_of_the_threshold_study_stay_good(seed):
    """In two of these piles planning asked for 1.8 and 4.6 times the acceleration of the arm."""
    cell, files = cell_and_files("yumi")
    plans, judge = list(of_threshold(cell, seed)), Judge()
    assert plans
    assert [why for plan in plans if (why := refused(judge, cell, files, plan))] == []


@pytest.mark.parametrize("name", FULL_BINS)
def test_plans_of_the_emptying_study_stay_good(name):
    cell, files = cell_and_files(name, "full_bin.toml")
    plans, judge = list(of_emptying(cell, name, 6, 2)), Judge()
    assert len(plans) >= 2
    assert [why for plan in plans if (why := refused(judge, cell, files, plan))] == []
