"""The HTTP interface: the same commands and the same rights as on the page."""

import io
import json
import threading
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
import requests
from waiting import PATIENCE

from workbench.app.core.cycle.jobs import JobEnded
from workbench.app.core.people import NOBODY, WORKER, Person, Role
from workbench.app.picking.proving import check
from workbench.app.runtime.live import Live
from workbench.app.runtime.worker import GettingReady
from workbench.formats.plans.certificates import read_certificate
from workbench.formats.plans.plan_files import read_plan
from workbench.model.messages.changes import ChangeText
from workbench.model.messages.states import LeftText
from workbench.model.messages.work import ProgressText
from workbench.model.prediction import EmptiedPile, Emptying, LeftPart, PileTask
from workbench.model.scan import LocalizationResult, ScaleCheck
from workbench.web.api.calls import CALLS
from workbench.web.api.fields import LARGEST_BODY
from workbench.web.api.resources import READS, AnswerSource

PROBLEM = "application/problem+json"


def plan(site) -> str:
    """Scan, find parts and plan; the plan's digest."""
    for path, phase in (("/scan", "scanned"), ("/localize", "localized"), ("/plan", "planned")):
        answer = site.post(path)
        assert answer.status_code == 202, answer.text
        site.reach(phase)
    return site.get("/plan").json()["digest"]


def detail(answer, status: int) -> str:
    assert answer.status_code == status, answer.text
    assert answer.headers["Content-Type"] == PROBLEM
    content = answer.json()
    assert content["status"] == status and content["title"]
    return content["detail"]


def test_a_whole_cycle_by_program(site, tmp_path):
    digest = plan(site)
    assert "play it first" in detail(site.post("/approve", plan=digest), 409)
    assert site.post("/watch", plan=digest).status_code == 200
    assert site.post("/approve", plan=digest).json()["phase"] == "approved"
    assert site.post("/send", plan=digest).status_code == 202
    site.reach("done")
    assert site.post("/report", detection=0, is_picked=True).status_code == 200
    state = site.get("/state").json()
    assert (state["phase"], state["parts_placed"]) == ("done", 2)
    assert state["approved_by"] == ["Ada"]
    assert state["approved_unwatched"] is True, "no page has drawn it"
    assert state["outcomes"] == [
        {"detection": 0, "is_picked": True, "by": "Ada", "why": "", "result": "picked"}
    ]
    assert site.post("/report", detection=0, is_picked=True, result="double").status_code == 200
    assert site.get("/state").json()["outcomes"][0]["result"] == "double"
    counted = site.get("/statistics").json()
    assert counted["picked"] == 2 and counted["cycles"] == 1
    assert site.get("/statistics").json() == counted, "nothing is counted twice"


def test_what_goes_out_is_what_was_approved_once_and_on_record(site):
    """Whatever a program tries: without approval, another plan, a robot elsewhere, twice."""
    digest = plan(site)
    assert "have the plan approved first" in detail(site.post("/send", plan=digest), 409)
    site.post("/watch", plan=digest)
    assert "have the plan approved first" in detail(site.post("/send", plan=digest), 409)
    site.stand(np.deg2rad(3.0))
    assert "the robot has moved" in detail(site.post("/approve", plan=digest), 409)
    site.stand(0.0)
    assert site.post("/approve", plan=digest).status_code == 200
    assert site.effects.sent == []
    assert "look at the current one" in detail(site.post("/send", plan="0" * 64), 409)
    site.stand(np.deg2rad(3.0))
    assert "the robot has moved" in detail(site.post("/send", plan=digest), 409)
    site.stand(0.0)
    assert site.effects.sent == []
    assert site.post("/send", plan=digest).status_code == 202
    site.reach("done")
    for path in ("/send", "/approve"):
        assert detail(site.post(path, plan=digest), 409)
    assert site.effects.sent == [digest]
    (seen,), (word,), (out,) = map(site.on_record, ("WatchPlan", "Approve", "SendPlan"))
    assert [one["actor"] for one in (seen, word, out)] == ["Ada"] * 3
    assert {one["command"]["plan_digest"] for one in (seen, word, out)} == {digest}
    assert seen["command"]["is_told"] is True, "no page has shown it"
    assert word["joints"] and out["joints"], "how the robot stood"


def test_what_a_cycle_has_made_can_be_read(site, results, tmp_path):
    digest = plan(site)
    file = tmp_path / "proof.json"
    file.write_bytes(site.get("/proof/certificate").content)
    certificate = read_certificate(file)
    assert certificate.plan.digest == digest
    assert check(site.bench.state.cell, certificate).holds
    scan = site.get("/scan").json()
    assert scan["digest"] == results.scan.digest and scan["points"] == len(results.scan.points)
    points = np.load(io.BytesIO(site.get("/scan/points").content))["points"]
    np.testing.assert_array_equal(points, results.scan.points)
    assert [one["part"] for one in site.get("/detections").json()] == ["keyed_cylinder"] * 2
    candidates = site.get("/candidates").json()
    assert {"OK"} < {one["verdict"]["reason"] for one in candidates}
    assert site.get("/proof").json()["holds"] is True
    (tmp_path / "plan.json").write_bytes(site.get("/plan").content)
    read, stated = read_plan(tmp_path / "plan.json")
    assert read.digest == stated == digest
    assert site.get("/sessions").json() == {"current": "session", "sessions": ["session"]}


def test_cad_files_of_a_wrong_size_are_told_with_the_parts_they_belong_to(site):
    plan(site)
    found = site.bench.state.detections
    sizes = (ScaleCheck("bolt", 0.97, 0.002, 4), ScaleCheck("bracket", 1.001, 0.002, 4))
    assert site.get("/state").json()["wrong_sizes"] == []
    site.effects.live = Live(findings=LocalizationResult(found, (), sizes))
    told = ["the CAD file of bolt seems 3.1% too large for the scan"]
    assert site.get("/state").json()["wrong_sizes"] == told
    assert site.get("/state").json()["wrong_parts"] == ["bolt"]
    site.effects.live = Live(findings=LocalizationResult(found[:1], (), sizes))
    assert site.get("/state").json()["wrong_sizes"] == []
    assert site.get("/state").json()["wrong_parts"] == []


def test_a_part_is_corrected_by_name_once_parts_are_found(site):
    assert "take a scan first" in detail(site.post("/part/correct", part="bolt"), 409)
    plan(site)
    assert "bolt" in detail(site.post("/part/correct", part="bolt"), 409)
    site.effects.hold.set()
    assert site.post("/part/correct", who="bob", part="keyed_cylinder").status_code == 403
    answer = site.post("/part/correct", part="keyed_cylinder")
    assert answer.status_code == 202
    assert site.get("/jobs/current").json()["job"]["name"] == "correct"
    (entry,) = site.on_record("CorrectPart")
    assert (entry["actor"], entry["command"]["part"]) == ("Ada", "keyed_cylinder")


def test_a_task_is_told_while_it_runs_and_can_be_cancelled(site):
    site.effects.hold.set()
    begun = site.post("/scan").json()
    answer = site.get("/jobs/current").json()["job"]
    assert (answer["number"], answer["name"]) == (begun["job"], "scan")
    assert "the scan ends or is cancelled" in detail(site.post("/localize"), 409)
    assert site.post("/cancel").json()["job"] is None
    assert site.get("/jobs/current").json()["job"] is None


def test_a_program_goes_on_after_a_cycle_and_a_person_approves(site):
    digest = plan(site)
    assert "approved first" in detail(site.post("/go-on"), 409)
    for path in ("/watch", "/approve", "/send"):
        assert site.post(path, plan=digest).ok
    site.reach("done")
    answer = site.post("/go-on", seed=1, threshold=0.25, least_score=0.1)
    assert answer.status_code == 202 and answer.json()["job"] is not None
    site.reach("planned")
    state = site.get("/state").json()
    assert state["approved_by"] == [] and state["watched"] == []
    assert site.bench.state.planned_threshold == 0.25
    assert [str(row.kind) for row in site.bench.entries()][-4:] == ["GoOn", *["JobEnded"] * 3]


def test_simulated_parts_that_are_left_stay_where_a_program_scans_again(site):
    for stays in (True, False):
        site.post("/scan", seed=2, parts=3)
        site.reach("scanned")
        first = site.bench.state.pile
        assert site.post("/scan", seed=2, parts=3, stays=stays).status_code == 202
        site.bench.wait(lambda state: state.job is None, PATIENCE)
        assert (site.bench.state.pile is None, first.left) == (not stays, 3)


def test_what_tasks_wait_for_is_told_with_the_state_and_with_the_task(site):
    assert site.get("/state").json()["getting_ready"] is None
    site.effects.hold.set()
    note = ProgressText.GETTING_READY()
    site.effects.live = Live(getting_ready=GettingReady(0.4, note))
    site.post("/scan")
    told = {"done": 0.4, "note": str(note)}
    assert site.get("/state").json()["getting_ready"] == told
    answer = site.get("/jobs/current").json()
    assert answer["getting_ready"] == told
    assert (answer["job"]["done"], answer["job"]["note"]) == (0.4, str(note))


def test_piles_are_emptied_and_what_came_of_them_is_read_as_the_study_prints_it(site):
    site.effects.hold.set()
    wanted = {"part": "keyed_cylinder", "parts": 2, "piles": 1, "seed": 5, "changes": "lifts"}
    begun = site.post("/emptying", **wanted).json()["job"]
    assert site.get("/jobs/current").json()["job"]["name"] == "emptying"
    task = PileTask("yumi", "keyed_cylinder", 2, 5)
    left = (LeftPart("part-2", "no path", LeftText.WAS_NOT_FOUND(), ""),)
    plain = EmptiedPile(task, 2, 1, (0, 0, 0), 0, 0, 1, 4, 5.0, left, (0.1,), (("prove", 0.1),),
                        0.0, outcomes=("",))  # fmt: skip
    more = replace(plain, task=replace(task, change=ChangeText.UP_ALONE()), taken=2, left=())
    site.bench.do(JobEnded(begun, Emptying("0" * 64, (plain, more))), WORKER)
    found = site.get("/emptying").json()
    assert (found["taken"], found["parts"], found["taken_share"]) == (1, 2, 0.5)
    assert found["scenes"][0]["left"][0]["reason"] == "it was not found"
    assert found["scenes"][0]["left"][0]["said"]["id"] == "left.was-not-found"
    assert [one["parts_gained"] for one in found["what_if"]] == [1]
    assert found["what_if"][0]["said"]["id"] == "change.up-alone"
    for wrong, status, says in (
        ({"part": "screw"}, 409, "part 'screw' is not known; there are keyed_cylinder"),
        ({"parts": 0}, 400, "parts"),
        ({"seen": "guess"}, 400, "seen"),
        ({"changes": "lifts+colours"}, 409, "kind of change 'colours' is not known"),
    ):
        assert says in detail(site.post("/emptying", **wrong), status)


@pytest.mark.parametrize("read", [read for read in READS if read.missing], ids=lambda r: r.path)
def test_what_is_not_there_yet_is_said_with_what_to_do(site, read):
    assert detail(site.get(read.path), 404) == f"it is not there yet: {read.missing}"


def test_nobody_is_told_anything_without_a_login(site):
    for read in READS:
        answer = site.get(read.path, who="")
        assert detail(answer, 401) == "log in first"
        assert answer.headers["WWW-Authenticate"] == "Bearer"
    for call in CALLS:
        detail(site.post(call.path, who="eve"), 401)
    detail(site.get("/events", who=""), 401)


def test_a_role_that_is_not_enough_is_forbidden(site):
    said = detail(site.post("/cell/save", who="bob"), 403)
    assert said == "saving the cell is for engineers; you are an operator"
    for call in CALLS:
        needed = {field.name: _some(field) for field in call.fields if field.is_required}
        assert "you are a viewer" in detail(site.post(call.path, who="vic", **needed), 403)
    assert site.get("/state", who="vic").status_code == 200
    assert site.get("/me", who="vic").json() == {"name": "Vic", "role": "viewer", "may": []}


def _some(field):
    if field.name in ("plan", "ran"):
        return "0" * 64
    if field.schema["type"] == "integer":
        return field.schema["minimum"]
    return {"number": 0.5, "boolean": True, "string": "x"}[field.schema["type"]]


def test_a_login_without_a_name_approves_nothing(site, people):
    people["Bearer first"] = Person(NOBODY, Role.ENGINEER)
    digest = plan(site)
    for path in ("/watch", "/approve"):
        assert "needs a name" in detail(site.post(path, who="first", plan=digest), 403)
    assert site.post("/scan", who="first").status_code == 202


def test_whoever_is_not_in_control_is_told_who_is(site):
    assert site.post("/control/take", who="bob").status_code == 200
    said = detail(site.post("/scan"), 409)
    assert said == "Bob is in control; ask for control first"
    assert site.post("/control/ask").status_code == 200
    assert site.get("/state").json()["asking"] == ["Ada"]
    assert site.post("/control/give", who="bob", to="Ada").status_code == 200
    assert site.post("/scan").status_code == 202


def test_a_stop_waits_for_no_readers(site, monkeypatch):
    over, begun = threading.Event(), threading.Semaphore(0)

    def counted(source):
        begun.release()
        over.wait(PATIENCE)
        return source.bench.state

    digest = plan(site)
    site.post("/watch", plan=digest)
    site.post("/approve", plan=digest)
    site.effects.hold.set()
    assert site.post("/send", plan=digest).json()["phase"] == "sending"
    monkeypatch.setattr(AnswerSource, "state", property(counted))
    # More than the threads that an event loop has on any machine.
    with ThreadPoolExecutor(40) as readers:
        for _ in range(40):
            readers.submit(requests.get, site.url + "/scan", headers=site.token("vic"))
        begun.acquire(timeout=PATIENCE)
        try:
            headers = site.token("bob")
            answer = requests.post(site.url + "/stop", json={}, headers=headers, timeout=PATIENCE)
            assert answer.status_code in (200, 202)
        finally:
            over.set()
    site.reach("fault")


def test_another_plan_than_the_current_one_is_not_approved(site):
    plan(site)
    said = detail(site.post("/approve", plan="0" * 64), 409)
    assert "look at the current one and decide again" in said


@pytest.mark.parametrize(
    ("path", "body", "says"),
    [
        ("/scan", b"{", "is not valid JSON"),
        ("/scan", b"[1]", "a JSON object is expected"),
        ("/scan", b"\xff", "UTF-8"),
        ("/scan", b'{"seed": 1, "seed": 2}', "there twice"),
        ("/scan", b'{"speed": 1}', "the key 'speed' is not known; there are parts, seed, stays"),
        ("/scan", b'{"seed": 1.5}', "a whole number from 0"),
        ("/scan", b'{"seed": true}', "a whole number from 0"),
        ("/scan", b'{"seed": null}', "a whole number from 0"),
        ("/scan", b'{"seed": -1}', "a whole number from 0"),
        ("/scan", b'{"seed": 1' + b"0" * 400 + b"}", "a whole number from 0"),
        ("/scan", b'{"seed": 1' + b"0" * 5000 + b"}", "valid JSON"),
        ("/scan", b'{"seed":' + b"[" * 30000, "nested too deeply"),
        ("/localize", b'{"detail": NaN}', "valid JSON"),
        ("/localize", b'{"detail": 1e999}', "a number from 0.3 to 2.0"),
        ("/plan", b'{"strategy": "' + b"a" * 81 + b'"}', "may have 80 characters"),
        ("/plan", b'{"strategy": ["auto"]}', "must be a text"),
        ("/threshold", b"", "the key threshold is missing"),
        ("/approve", b'{"plan": "abc"}', "must look like"),
        ("/approve", b'{"plan": "' + b"0" * 64 + b'\\n"}', "must look like"),
        ("/report", b'{"detection": 0, "is_picked": "yes"}', "must be true or false"),
        ("/cell/save", json.dumps({"remark": "x" * 201}).encode(), "may have 200 characters"),
    ],
)
def test_a_body_that_cannot_be_used_is_refused_with_its_key(site, path, body, says):
    headers = {**site.token("ada"), "Content-Type": "application/json"}
    answer = site.session.post(site.url + path, data=body, headers=headers, timeout=PATIENCE)
    assert says in detail(answer, 400)
    assert site.bench.state.number == 1, "nothing was done"


def test_the_strategies_of_the_cell_are_told_and_each_arm_can_be_asked_for(site):
    there = ["auto", "alternated", "coordinated", "right", "left", "both"]
    assert site.get("/state").json()["strategies"] == there
    for path, phase in (("/scan", "scanned"), ("/localize", "localized")):
        assert site.post(path).status_code == 202
        site.reach(phase)
    said = detail(site.post("/plan", strategy="both arms"), 409)
    assert said == f"strategy 'both arms' is not known; there are {', '.join(there)}"
    assert site.post("/plan", strategy="left").status_code == 202


def test_a_whole_number_may_be_written_with_a_point(site):
    headers = {**site.token("ada"), "Content-Type": "application/json"}
    answer = site.session.post(
        site.url + "/scan", data=b'{"parts": 3.0}', headers=headers, timeout=120
    )
    assert answer.status_code == 202


def test_a_body_of_another_kind_or_too_long_is_not_read(site):
    headers = {**site.token("ada"), "Content-Type": "text/plain"}
    answer = site.session.post(site.url + "/scan", data=b"{}", headers=headers, timeout=PATIENCE)
    assert "must be application/json" in detail(answer, 415)
    long = b" " * (LARGEST_BODY + 1)
    headers = {**site.token("ada"), "Content-Type": "application/json"}
    answer = site.session.post(site.url + "/scan", data=long, headers=headers, timeout=PATIENCE)
    assert "a body may have" in detail(answer, 413)
    chunks = (b" " * 1024 for _ in range(100))
    answer = site.session.post(site.url + "/scan", data=chunks, headers=headers, timeout=PATIENCE)
    detail(answer, 413)


def test_the_description_and_its_page_need_no_login_and_nothing_from_outside(site):
    description = site.get("/openapi.json", who="").json()
    assert description["openapi"] == "3.1.0"
    page = site.get("/", who="")
    assert page.headers["Content-Type"].startswith("text/html")
    assert "<script" not in page.text and "http" not in page.text
    for path in description["paths"]:
        assert f"/api/v1{path}</code>" in page.text
