"""A change of tool over HTTP."""


def test_a_tool_without_slot_is_refused_in_a_sentence_and_viewers_change_none(site):
    (tool,) = {arm.tool.name for arm in site.bench.state.cell.arms}
    arm = site.bench.state.cell.arms[0].name
    answer = site.post("/tool", tool=tool)
    assert answer.status_code == 409
    assert answer.json()["said"]["text"] == f"the {arm} arm carries {tool} already"
    assert "has no tool" in site.post("/tool", tool="spoon", arm=arm).json()["said"]["text"]
    assert site.post("/tool").status_code == 400
    assert site.post("/tool", who="vic", tool="spoon").status_code == 403
