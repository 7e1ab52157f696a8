"""What others publish comes to what it has to, by the documented commands."""

import made_arm
import pytest
from bring import DATA, Brought, bring, corpus

NOT_HERE = pytest.mark.skipif(
    not DATA.is_dir(),
    reason="the public data is not here: ../shared/data/foreign beside the checkout",
)

QUICK = [one for one in corpus() if not one.is_slow]


@NOT_HERE
@pytest.mark.parametrize("one", QUICK, ids=lambda one: one.name)
def test_what_others_publish_comes_to_what_it_has_to(one, tmp_path):
    out = bring(one, tmp_path, demo=False)
    assert out.is_as_wanted, (out.ends, out.said)


def test_an_arm_in_the_words_of_its_maker_becomes_a_cell_that_picks(tmp_path):
    (tmp_path / "made.urdf").write_text(made_arm.arm())
    brought = Brought("robot", "made", "made.urdf", (0, 0, 0))
    out = bring(brought, tmp_path, tmp_path)
    assert out.is_as_wanted, (out.ends, out.said)
    assert len(out.ends) == 3


def test_what_is_not_as_wanted_is_said(tmp_path):
    (tmp_path / "made.urdf").write_text("<robot")
    out = bring(Brought("robot", "cut off", "made.urdf", (0, 0, 0)), tmp_path, tmp_path)
    assert out.ends == (2,) and not out.is_as_wanted
    assert "made.urdf" in out.sentence
