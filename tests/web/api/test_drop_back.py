"""A drop back over HTTP."""


def test_it_begins_where_the_arms_are_reported_and_is_refused_in_a_sentence(site):
    arm = site.bench.state.cell.arms[0].name
    answer = site.post("/drop-back", held="one", arm=arm)
    assert answer.status_code == 409
    said = answer.json()["said"]
    assert said["text"] == f"the controller does not report where arm {arm} stands"
    assert "no arm 'middle'" in site.post("/drop-back", arm="middle").json()["said"]["text"]
    assert site.post("/drop-back", held="three").status_code == 400
    assert site.post("/drop-back", who="vic").status_code == 403
