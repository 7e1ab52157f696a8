"""A part whose CAD file is too large for the scan is corrected on the page, in a real browser."""

import pytest

from workbench.app.core.cell.changes import UndoCell
from workbench.app.core.cycle.scanning import UseScan
from workbench.app.core.state import Phase
from workbench.formats.cells.reading import read_cell
from workbench.formats.files.shipped import find
from workbench.formats.parts.reading import read_part
from workbench.formats.parts.scales import write_shape
from workbench.perception.simulation.piles import pile_of
from workbench.perception.simulation.synthesize import synthesize

PART, SEED = "keyed_cylinder", 3


@pytest.fixture
def seen(own):
    """A scan of the parts as they are; from then on their file has them 8 % larger."""
    cell = read_cell("yumi")
    scan = synthesize(cell, pile_of(cell, "", 4, seed=SEED), seed=SEED)
    write_shape(own / "parts" / PART, 1.08, 0.0)
    return scan


@pytest.fixture
def bench(seen, own_bench):
    return own_bench


@pytest.fixture
def url(bench, own_url):
    return own_url


@pytest.mark.extensive
def test_a_part_is_corrected_to_the_size_that_the_scan_shows(screen, bench, wait, reaches, seen):
    file = find("parts", PART)
    bench.do(UseScan(seen), "Ada")
    reaches("scanned")
    screen.press("Find parts")
    reaches("localized")
    screen.wait_for(f"The CAD file of {PART} seems")
    button = screen.button(f"Correct {PART}")
    screen.shoot("correcting-1-too-large")
    screen.press("Plan")
    wait(lambda: bench.state.job is None and bench.state.candidates is not None, "no planning")
    screen.press(f"Correct {PART}")
    wait(lambda: bench.state.cell.parts[0].scale < 1.01, "the part is as large as before")
    found = reaches("localized")
    assert found.candidates is None and found.plan is None and len(found.detections) == 4
    assert bench.live.wrong_parts(found.detections) == ()
    button.wait_for(state="hidden")
    wait(lambda: bench.state.is_saved, "the part is not saved")
    # What was found stands: the file holds the part that it was found with.
    assert bench.state.phase is Phase.LOCALIZED
    assert read_part(file).digest == bench.state.cell.parts[0].digest
    screen.shoot("correcting-2-corrected")
    bench.do(UndoCell(), "Ada")
    assert bench.state.cell.parts[0].scale == 1.08 and not bench.state.is_saved
    screen.press("Find parts")
    button.wait_for(state="visible")
    assert [one for one in screen.errors if "favicon" not in one] == []
