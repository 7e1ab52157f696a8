"""What takes longest is begun first, and is there."""

from pathlib import Path

import pytest
from conftest import HERE, LONGEST, place_in_line


@pytest.mark.parametrize("long", LONGEST)
def test_what_is_begun_first_is_there(long):
    assert (HERE / long).exists()


def test_a_long_file_comes_before_a_short_one():
    browser, short = HERE / "browser" / "test_page.py", HERE / "model" / "test_digest.py"
    assert place_in_line(browser) < place_in_line(Path(HERE / "examples" / "test_examples.py"))
    assert place_in_line(HERE / "examples" / "test_examples.py") < place_in_line(short)
