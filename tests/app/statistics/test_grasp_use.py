"""The turns that a symmetry gives a grasp are counted as that grasp."""

from workbench.app.statistics.grasp_use import GraspUse, add_uses, count_judged, count_taken


def candidate(detection, grasp, reason):
    return {"detection": detection, "grasp": {"name": grasp}, "verdict": {"reason": reason}}


def test_turns_of_a_symmetry_count_as_their_grasp():
    found = [
        candidate(0, "side", "ok"),
        candidate(0, "side@60", "in collision"),
        candidate(1, "side@120", "ok"),
    ]
    assert count_judged(("bolt", "nut"), found) == {
        ("bolt", "side"): GraspUse(tried=2, possible=1),
        ("nut", "side"): GraspUse(tried=1, possible=1),
    }
    uses = count_taken([("bolt", "side@60", "picked"), ("bolt", "side", "unknown")])
    assert uses == {("bolt", "side"): GraspUse(planned=2, picked=1)}


def test_sums_leave_what_is_summed_alone():
    one = {("bolt", "side"): GraspUse(1, 1, 1, 1, 0)}
    assert add_uses(one, one, {("nut", "top"): GraspUse(tried=1)}) == {
        ("bolt", "side"): GraspUse(2, 2, 2, 2, 0),
        ("nut", "top"): GraspUse(tried=1),
    }
    assert one == {("bolt", "side"): GraspUse(1, 1, 1, 1, 0)}
