"""After a stop with a part in the hand: dropped back by pressing, then scanned anew."""

import pytest
from playwright.sync_api import expect
from test_page import approve, seen


@pytest.mark.extensive
@pytest.mark.parametrize("speed", [0.1])
def test_a_part_in_the_hand_after_a_stop_is_dropped_back(screen, bench, robot, reaches, wait):
    screen.press("Scan")
    reaches("scanned")
    screen.press("Find parts")
    reaches("localized")
    screen.page.get_by_role("combobox", name="Strategy").click()
    screen.page.get_by_role("option", name="right arm only").click()
    screen.press("Plan")
    reaches("planned")
    seen(bench)
    approve(screen, "Bo")
    reaches("approved")
    screen.press("Send")
    wait(lambda: bench.live.link.step >= 4, "the robot to carry the part")
    screen.press("Stop")
    reaches("fault")
    wait(lambda: str(bench.live.robot) == "fault: stopped by the client", "the robot to stand")
    expect(screen.button("Drop back")).to_be_hidden()
    screen.press("Acknowledge")
    reaches("idle")
    screen.page.get_by_role("combobox", name="In the hand").click()
    screen.page.get_by_role("option", name="one part").click()
    screen.shoot("d1-stopped")
    screen.press("Drop back")
    state = reaches("planned")
    assert state.plan.is_drop_plan and state.proof.holds and state.scan is None
    screen.wait_for("drops back what it holds (one part)")
    seen(bench)
    approve(screen, "Bo")
    reaches("approved")
    screen.shoot("d2-approved")
    screen.press("Send")
    done = reaches("done")
    assert "has dropped back what it held" in str(done.message) and done.parts_placed == 0
    expect(screen.button("Drop back")).to_be_hidden()
    screen.press("Scan")
    reaches("scanned")
