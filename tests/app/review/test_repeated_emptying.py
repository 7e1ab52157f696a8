"""Piles on record are emptied again by the same seeds, and come out the same."""

import pytest
from idle import Idle

from workbench.app.core.cell.emptying import TryEmptying
from workbench.app.core.cycle.jobs import JobEnded
from workbench.app.emptying.piles import emptied_piles
from workbench.app.review.likeness import Likeness
from workbench.app.review.recompute import recompute_tasks
from workbench.app.runtime.bench import Bench
from workbench.formats.cells.reading import read_cell
from workbench.journal.journal import Journal
from workbench.model.errors import CommandRefused
from workbench.plugins.progress import never, silent


@pytest.mark.extensive
def test_what_is_on_record_is_what_comes_out_again(tmp_path):
    cell, asked = read_cell("yumi"), TryEmptying(count=3, piles=1, seed=13)
    bench = Bench(cell, Journal(tmp_path / "session"), effects=Idle)
    number = bench.do(asked, "ada").number
    found = emptied_piles(cell, asked, silent, never).emptying
    assert bench.do(JobEnded(number, found), "worker").emptying == found
    bench.close()
    journal = Journal(tmp_path / "session")
    (comparison,) = recompute_tasks(journal)
    journal.close()
    assert (comparison.task, comparison.likeness) == ("emptying", Likeness.EQUAL)
    # Whoever goes on with the session still has the table.
    again = Bench(cell, Journal(tmp_path / "session"), effects=Idle)
    assert again.state.emptying == found
    again.close()


def test_a_bench_refuses_at_once_what_no_worker_could_do(tmp_path):
    bench = Bench(read_cell("yumi"), Journal(tmp_path / "session"), effects=Idle)
    with pytest.raises(CommandRefused, match="do not fit into the bin; take 29 or fewer"):
        bench.do(TryEmptying(count=30), "ada")
    assert bench.state.job is None
    bench.close()
