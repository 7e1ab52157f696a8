"""Recipes over HTTP."""

import pytest
from prepared_bench import results_with_recipes


@pytest.fixture(scope="module")
def results():
    return results_with_recipes()


def test_a_recipe_is_read_and_chosen_by_number_and_is_on_record(site):
    state = site.get("/state").json()
    assert state["recipe"] == 0
    assert state["recipes"] == [{"number": 4, "name": "left"}, {"number": 12, "name": "slow"}]
    for path, phase in (("/scan", "scanned"), ("/localize", "localized")):
        site.post(path)
        site.reach(phase)
    answer = site.post("/recipe", who="bob", number=4)
    assert (answer.status_code, answer.json()["phase"]) == (200, "scanned")
    chosen = site.get("/state").json()
    assert (chosen["recipe"], chosen["phase"], chosen["detections"]) == (4, "scanned", None)
    assert chosen["cell_digest"] != state["cell_digest"] and chosen["scan"] is not None
    assert chosen["said"]["id"] == "recipe.chosen"
    assert chosen["is_saved"] == state["is_saved"]
    site.post("/localize")
    site.reach("localized")
    assert site.post("/plan").status_code == 202
    (recipe,), (planning,) = map(site.on_record, ("ChooseRecipe", "MakePlan"))
    assert recipe["command"]["number"] == 4
    assert (planning["command"]["strategy"], planning["command"]["threshold"]) == ("", None)


def test_unknown_recipes_are_refused_and_viewers_choose_none(site):
    answer = site.post("/recipe", number=5)
    assert answer.status_code == 409
    assert answer.json()["said"] | {"args": {}} == {
        "id": "recipe.unknown",
        "args": {},
        "text": "cell yumi has no recipe 5; it has 4 left, 12 slow",
    }
    assert site.post("/recipe", number="4").status_code == 400
    assert site.post("/recipe").status_code == 400
    assert site.post("/recipe", who="vic", number=4).status_code == 403
    assert site.get("/state").json()["recipe"] == 0
