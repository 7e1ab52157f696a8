"""What takes longest is begun first, and is there."""

import pytest
from conftest import HERE, LONGEST, place_in_line


@pytest.mark.parametrize("long", LONGEST)
def test_what_is_begun_first_is_there(long):
    assert (HERE / long).exists()


def test_a_long_file_comes_before_a_short_one():
    browser, examples = "browser/test_page.py", "examples/test_examples.py"
    assert place_in_line(browser) < place_in_line(examples) < place_in_line("model/test_digest.py")
