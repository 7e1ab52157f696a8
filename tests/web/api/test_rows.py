"""Several picks after one scan, over HTTP."""

import pytest
from prepared_bench import make_row


@pytest.fixture(scope="module")
def results():
    return make_row(picks=4)


def planned(site):
    for path, phase in (("/scan", "scanned"), ("/localize", "localized")):
        site.post(path)
        site.reach(phase)
    assert site.post("/plan", picks=4).status_code == 202
    site.reach("planned")
    row = site.get("/state").json()["row"]
    return row, row[0]["plan"], "+".join(one["plan"] for one in row[1:])


def test_a_row_is_read_approved_and_sent_by_its_digests(site, results):
    row, plan, after = planned(site)
    assert [one["plan"] for one in row] == [one.digest for one in results.planned.plans]
    assert [one["digest"] for one in site.get("/row").json()] == [one["plan"] for one in row]
    assert sorted(number for one in row for number in one["parts"]) == [0, 1, 2, 3]
    assert all(one["holds"] and one["clearance"] > 0 and not one["is_sent"] for one in row)
    assert site.get("/state").json()["row_ends"] == "no part is left"
    for path in ("/watch", "/approve"):
        answer = site.post(path, plan=plan)
        assert answer.status_code == 409 and "look at the current row" in answer.json()["detail"]
    assert site.post("/watch", plan=plan, row=after).status_code == 200
    assert site.post("/approve", plan=plan, row=after).json()["phase"] == "approved"
    assert site.post("/send", plan=plan).status_code == 202
    site.reach("done")
    state = site.get("/state").json()
    assert state["parts_placed"] == 4
    assert all(one["is_sent"] for one in state["row"]) and len(state["row"]) == len(row)
    assert sorted(one["detection"] for one in state["outcomes"]) == [0, 1, 2, 3]
    counted = site.get("/statistics").json()
    assert (counted["picked"], counted["cycles"]) == (4, 1)


def test_a_row_is_shortened_and_made_longer_again(site):
    row, plan, after = planned(site)
    site.post("/watch", plan=plan, row=after.split("+"))
    site.post("/approve", plan=plan, row=after.split("+"))
    assert site.post("/row", plan=plan, picks=1).json()["phase"] == "planned"
    state = site.get("/state").json()
    assert [one["plan"] for one in state["row"]] == [plan]
    assert state["row_left_out"] == len(row) - 1 and state["approved_by"] == []
    assert site.post("/send", plan=plan).status_code == 409
    assert site.post("/row", plan=plan, picks=len(row)).status_code == 200
    assert site.get("/state").json()["row"] == row
    answer = site.post("/approve", plan=plan, row=after)
    assert answer.status_code == 409 and "play it first" in answer.json()["detail"]
    assert answer.json()["said"]["id"] == "refusal.not-played"


@pytest.mark.parametrize(
    ("path", "body", "said"),
    [
        ("/plan", {"picks": 0}, "from 1 to 10"),
        ("/plan", {"picks": 11}, "from 1 to 10"),
        ("/row", {"picks": 2.5}, "whole number"),
        ("/watch", {"row": "no digest"}, "must look like"),
        ("/approve", {"row": [7]}, "must be a text"),
        ("/approve", {"row": ["0" * 64] * 10}, "may have 9 entries"),
        ("/approve", {"plan": ["0" * 64]}, "must be a text"),
    ],
)
def test_what_no_row_can_be_is_refused(site, path, body, said):
    body = body if path == "/plan" else {"plan": "0" * 64, **body}
    answer = site.post(path, **body)
    assert answer.status_code == 400 and said in answer.json()["detail"]
