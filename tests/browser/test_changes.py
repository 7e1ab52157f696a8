"""What has changed since the start before is read on the page, and acknowledged there."""

from workbench.app.core.people import SESSION_START
from workbench.app.core.session import Started
from workbench.app.provenance.gathering import inventory


def test_an_engineer_reads_what_has_changed_and_acknowledges_it(bench, screen, wait):
    changes = tuple(f"distribution-{number} 1.0.{number} is now 2.0.0" for number in range(9))
    assert not screen.button("Changes seen").is_visible()
    bench.do(Started(inventory(bench.cell, {}), changes, "session of yesterday"), SESSION_START)
    screen.wait_for("distribution-8 1.0.8 is now 2.0.0")
    screen.shoot("changes")
    screen.press("Changes seen")
    wait(lambda: bench.state.changed == (), "the changes are acknowledged")
    screen.wait_for("acknowledged the changes since session of yesterday")
    assert not screen.button("Changes seen").is_visible()
