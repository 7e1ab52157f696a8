"""What one message says."""

from arm_scanner_cell import on_arm_cell

from workbench.app.empty_hand.view_plan import plan_view
from workbench.extras.mcap.foxglove import plan_message


def test_the_path_of_a_scanner_to_its_view_has_no_part():
    result = plan_view(on_arm_cell())
    (arm,) = plan_message(0.0, result.plan, result.proof)["arms"]
    assert arm["part"] == "" and [leg["name"] for leg in arm["legs"]] == ["view"]
