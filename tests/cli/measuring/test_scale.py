"""`workbench bench scale` measures growth."""

import json


def test_the_costs_of_a_bin_are_measured_at_each_size(say):
    said = say("bench", "scale", "--of", "bin", "--parts", 3, 2, "--json")
    assert said.code == 0, said.err
    growth = json.loads(said.out)["growth"]
    steps = {row["step"]: row for row in growth}
    assert {"simulate the pile, s", "plan and prove, s", "the scene, kB"} <= set(steps)
    for row in growth:
        assert row["subject"] == "parts in the bin" and row["sizes"] == [2, 3]
        assert all(cost > 0 for cost in row["costs"]) and len(row["exponents"]) == 1


def test_a_size_of_nothing_is_refused(say):
    said = say("bench", "scale", "--of", "bin", "--parts", 0)
    assert said.code != 0 and "--bin" in said.err
