"""The study of emptying, drawn."""

from made_piles import scene

from workbench.app.emptying.summary import summary
from workbench.studies.emptying.plot import draw_emptying


def test_the_plot_is_one_file_with_every_pile(tmp_path):
    found = summary([scene(4, 6, 2), scene(5, 0, 8)], scan_seconds=1.0, approval_seconds=0.0)
    draw_emptying(tmp_path / "emptied.html", found, "two piles")
    text = (tmp_path / "emptied.html").read_text()
    assert "seed 4" in text and "seed 5" in text and "two piles" in text
