"""What the RAPID modules say on the wire is what the simulated controller says."""

from wires import compare


def test_random_programs_good_and_bad_are_answered_the_same_by_both(cell):
    """A sample; `python tests/devices/wires.py 200` runs more."""
    ends, messages, _ = compare(cell, range(24), share_stepped=0.12)
    assert ends["done"] >= 8 and ends["no"] >= 3 and ends["stepped"] >= 2
    assert messages > 300
