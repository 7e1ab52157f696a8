"""What on a page is smaller or paler than people read."""

from pathlib import Path

LEAST_SIZE = 12.0
"""[px] Of letters."""

LEAST_CONTRAST = 4.5
"""Between letters and what is behind them: WCAG 2.2, 1.4.3."""

SCRIPT = Path(__file__).with_suffix(".js").read_text(encoding="utf-8")


def unreadable(page):
    """Texts in view that are too small or too pale, each with its figure; not what is disabled."""
    return page.evaluate(SCRIPT, [LEAST_SIZE, LEAST_CONTRAST])
