"""The study of emptying, drawn."""

from workbench.app.emptying.summary import summary
from workbench.model.prediction import EmptiedPile, LeftPart, PileTask
from workbench.studies.emptying.plot import draw_emptying


def scene(seed: int, taken: int, left: int) -> EmptiedPile:
    stays = tuple(
        LeftPart(f"part-{k + 1}", "tool collision", "in the way", "") for k in range(left)
    )
    return EmptiedPile(
        task=PileTask("yumi", "", taken + left, seed),
        parts=taken + left,
        taken=taken,
        failed=(0, 0, 0),
        touches=0,
        knocked_out=0,
        cycles=taken,
        scans=taken + 3,
        motion_seconds=10.0 * taken,
        left=stays,
        planning=(0.1, 0.3),
        stages=(("propose", 0.4),),
        finding=0.0,
    )


def test_the_plot_is_one_file_with_every_pile(tmp_path):
    found = summary([scene(4, 6, 2), scene(5, 0, 8)], scan_seconds=1.0, approval_seconds=0.0)
    draw_emptying(tmp_path / "emptied.html", found, "two piles")
    text = (tmp_path / "emptied.html").read_text()
    assert "seed 4" in text and "seed 5" in text and "two piles" in text
