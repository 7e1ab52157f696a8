"""What the page says, and that nothing from outside becomes HTML."""

import re
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest

from workbench.app.core.picks import Avoided, Outcome
from workbench.app.core.state import Job, Phase
from workbench.app.runtime.live import Live
from workbench.app.runtime.worker import GettingReady
from workbench.gui.cycle.approval_views import approval_line, facts_html
from workbench.gui.cycle.plan_views import plan_line
from workbench.gui.cycle.sending_views import send_line
from workbench.gui.parts.views import avoided_html, rejected_html
from workbench.gui.plan.curves import lanes_html, now_html
from workbench.gui.plan.views import plan_html
from workbench.gui.shared import link_views, views
from workbench.gui.shared.look import View
from workbench.gui.shared.tables import COLUMNS, PAGE, CandidateOrder, candidates_html, funnel_html
from workbench.model.candidate import Candidate, Reason, Stage, Verdict
from workbench.model.geometry import pose_from_rpy
from workbench.model.messages.message import plain
from workbench.model.motion import at_least
from workbench.model.part import Grasp
from workbench.model.prediction import Forecast, Predictions
from workbench.model.release import LinkStatus, PartReport, Vote
from workbench.model.robot import AxisMapping
from workbench.model.scan import Objection, RejectedHypothesis

NOW = 1_760_000_000.0
EVIL = "\"'><img src=x onerror=alert(1)><script>alert(2)</script>&amp;"
TABLE = {"table", "thead", "tbody", "tr", "th", "td"}
TAGS = {"ol", "small", "li", "span", "div", "b", "i", "details", "summary"} | TABLE


class Reader(HTMLParser):
    """Notes tags, attributes and text."""

    def __init__(self, html: str):
        super().__init__()
        self.tags: list[str] = []
        self.attributes: list[tuple[str, str]] = []
        self.text = ""
        self.feed(html)

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.attributes += [(name, value or "") for name, value in attrs]

    def handle_data(self, data):
        self.text += data


def classes_of_steps(html: str) -> list[str]:
    return re.findall(r'<li class="wb-(\w+)"', html)


def test_discarded_poses_are_listed_with_score_and_reason():
    T = pose_from_rpy((0, 0, 0))
    some = (
        RejectedHypothesis(EVIL, T, 0.61, Objection.TWIN, 1),
        RejectedHypothesis("bolt", T, 0.2, Objection.FREE_SPACE),
    )
    listed = Reader(rejected_html(some))
    assert set(listed.tags) <= TAGS | {"details", "summary", "ul"}
    for word in ("2 rejected hypotheses", "0.61", "a twin with a worse score: part-2", "0.20"):
        assert word in listed.text
    assert EVIL in listed.text


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("idle", ["next", "ahead", "ahead", "ahead", "ahead"]),
        ("scanned", ["done", "next", "ahead", "ahead", "ahead"]),
        ("localized", ["done", "done", "next", "ahead", "ahead"]),
        ("planning", ["done", "done", "busy", "ahead", "ahead"]),
        ("planned", ["done", "done", "done", "next", "ahead"]),
        ("approved", ["done", "done", "done", "done", "next"]),
        ("sending", ["done", "done", "done", "done", "busy"]),
        ("done", ["done", "done", "done", "done", "done"]),
        ("fault", ["done", "done", "done", "done", "fault"]),
    ],
)
def test_the_strip_shows_what_is_done_and_what_comes_next(states, name, expected):
    assert classes_of_steps(views.strip_html(getattr(states, name))) == expected


def test_a_task_that_is_no_step_keeps_no_step_busy(states):
    busy = replace(states.localized, job=Job(7, "emptying"))
    assert "busy" not in classes_of_steps(views.strip_html(busy))


def test_every_phase_has_its_place_in_the_strip():
    assert set(views.REACHED) == set(Phase)


def test_the_status_of_a_task_tells_its_step_and_its_time(states, view_of):
    live = Live(job=7, done=0.5, note="candidate 3 of 60", started=view_of(states.idle).at - 2.5)
    text = Reader(views.status_html(view_of(states.planning, live=live))).text
    assert "Candidate 3 of 60" in text
    assert "2.5 s" in text


def test_progress_of_another_task_is_not_shown(states, view_of):
    live = Live(job=6, done=0.5, note="old news", started=1.0)
    assert "old news" not in views.status_html(view_of(states.planning, live=live))


@pytest.mark.parametrize("name", ["idle", "planned", "planning"])
def test_while_it_gets_ready_the_page_says_so_and_how_far_it_is(states, view_of, name):
    ready = GettingReady(0.4, "getting ready, once, about a minute")
    state = getattr(states, name)
    number = state.job.number if state.job is not None else 0
    live = Live(job=number, started=NOW - 2.5, getting_ready=ready)
    text = Reader(views.status_html(view_of(state, live=live))).text
    assert "Getting ready, once, about a minute" in text and "40%" in text
    assert "2.5 s" not in text
    assert (f"then: {state.message}" in text) is (name == "planning")
    assert "etting ready" not in views.status_html(view_of(state))


def test_a_fault_and_a_sending_are_shown_although_it_gets_ready(states, view_of):
    live = Live(getting_ready=GettingReady(0.4, "getting ready"))
    assert "wb-status-fault" in views.status_html(view_of(states.fault, live=live))
    assert "placed" in views.status_html(view_of(states.sending, live=live))


def test_a_fault_is_shown_in_full(states, view_of):
    assert "the controller closed the link" in views.status_html(view_of(states.fault))


def test_a_cycle_with_a_part_that_was_lost_does_not_look_well_done(states, view_of):
    assert "wb-status-good" in views.status_html(view_of(states.done))
    lost = replace(states.done, outcomes=(Outcome(0, True, "Anna"), Outcome(1, False, "Anna")))
    assert "wb-status-fault" in views.status_html(view_of(lost))


def test_steps_that_have_to_wait_say_for_what(states):
    assert 'title="take a scan first"></div>' in views.parts_line(states.idle)
    assert 'title="find the parts first"></div>' in plan_line(states.scanned)


def test_results_of_the_steps_carry_units(states):
    assert "3,600 points (a drawn floor), 08:53:20 UTC" in views.scan_line(states.planned)
    assert "2 parts, score 0.90, 0.90" in views.parts_line(states.planned)
    assert "wb-bad" not in views.parts_line(states.planned)
    said = views.parts_line(states.planned, ("the CAD file of <a> seems 3.0% too large",))
    assert "wb-bad" in said and "The CAD file of &lt;a&gt; seems 3.0% too large." in said


def test_a_plan_whose_proof_does_not_hold_says_what_was_found(states):
    nearest = states.planned.proof.nearest
    proof = replace(states.planned.proof, violations=(replace(nearest, problem="too close"),))
    line = plan_line(replace(states.planned, proof=proof))
    assert "wb-bad" in line
    assert "too close" in line


def test_without_a_plan_the_verdict_stands_in_its_place(states):
    verdict = Verdict(Reason.NO_PATH, Stage.ROUTE, ("left_link_5", "bin_wall_left"), 0.0011)
    line = Reader(plan_line(replace(states.localized, verdict=verdict)))
    assert "No plan: no path: left_link_5 and bin_wall_left, 1.1 mm" in line.text


def test_an_approval_names_the_person_and_its_end(states, view_of):
    approval = states.approved.approval
    assert "By Anna until 08:58:20 UTC" in approval_line(states.approved, approval.at, "")
    assert "run out" in approval_line(states.approved, approval.until, "")


def test_what_is_approved_is_told_in_full(cell, states):
    plan, proof = states.planned.plan, states.planned.proof
    text = Reader(facts_html(states.planned, {}, 0.0)).text
    for expected in (
        plan.digest[:12],
        str(plan.strategy),
        str(plan.guarantee),
        at_least(proof.clearance),
        *proof.nearest.pair,
        f"{plan.cycle_seconds:.1f} s",
        *(arm.grasp for arm in plan.arms),
        *(f"part-{arm.detection + 1}" for arm in plan.arms),
    ):
        assert expected in text


def test_who_is_missing_is_told(states):
    two = replace(states.planned, cell=replace(states.planned.cell, approvers=2))
    assert "2 approvals are needed." in approval_line(two, 0.0, "")
    vote = Vote(two.plan.digest, "Anna", 1_760_000_000.0)
    one_more = replace(two, votes=(vote,))
    text = approval_line(one_more, vote.at + 60, "")
    assert "By Anna until 08:58:20 UTC, waiting for 1 more person." in text
    assert "approved: Anna" in facts_html(one_more, {}, vote.at)
    assert "2 approvals are needed." in approval_line(one_more, vote.at + 300, "")


def test_an_approved_plan_that_is_stale_says_so(states):
    text = approval_line(states.approved, states.approved.approval.at, "the robot has moved: ...")
    assert "wb-bad" in text and "The robot has moved" in text
    gone = replace(states.scanned, stale="plan a1 is stale: the bin was moved by 5.0 mm")
    assert "Plan a1 is stale: the bin was moved by 5.0 mm." in plan_line(gone)


def test_where_the_robot_stands_is_among_the_facts(cell, states):
    state = states.planned
    home = {j: q for arm in cell.arms for j, q in zip(arm.joints, arm.home, strict=True)}

    def facts(joints):
        return facts_html(state, joints, 0.0)

    assert "is where the plan starts" in facts(home)
    away = home | {cell.arms[0].joints[0]: home[cell.arms[0].joints[0]] + np.deg2rad(3)}
    assert "axis 1 of the right arm stands 3.00 deg" in facts(away)
    assert "check that it is where the plan starts" in facts({})


def test_what_is_avoided_is_told_with_what_remains(states):
    marks = (
        Avoided("peg", (0.01, -0.02, 0.0), 600.0, 2, "slipped"),
        Avoided("peg", (0.0, 0.0, 0.0), 10.0, 2),
        Avoided(EVIL, (0.0, 0.0, 0.0), 600.0, 0, EVIL),
    )
    html = avoided_html(replace(states.scanned, avoided=marks), 100.0)
    reader = Reader(html)
    assert "peg at 10, -20 mm in the bin" in reader.text
    assert "avoided for 2 more scans, at most 9 min (slipped)" in reader.text
    assert "in this scan" in reader.text and set(reader.tags) <= TAGS
    assert reader.text.count("avoided") == 2


def test_joints_are_told_in_degrees_in_the_order_of_the_controller(cell):
    arm = cell.arms[0]
    joints = dict(zip(arm.joints, arm.home, strict=True))
    rows = re.findall(
        r"<tr><th>Axis (\d)</th><td[^>]*>([-\d.]+)</td>", link_views.joints_html(cell, joints)
    )
    expected = [0, -130, 30, 0, 40, 0, -135]
    assert [int(axis) for axis, _ in rows] == [1, 2, 3, 4, 5, 6, 7]
    np.testing.assert_allclose([float(value) for _, value in rows], expected, atol=0.005)


def test_joints_are_shown_as_a_controller_with_coupled_axes_counts_them(cell):
    coupled = np.eye(7)
    coupled[2, 1] = -1.0
    arm = replace(cell.arms[0], mapping=AxisMapping(coupled, np.zeros(7)))
    joints = dict(zip(arm.joints, arm.home, strict=True))
    html = link_views.joints_html(replace(cell, arms=(arm, *cell.arms[1:])), joints)
    rows = re.findall(r"<tr><th>Axis (\d)</th><td[^>]*>([-\d.]+)</td>", html)
    shown = [float(value) for _, value in rows]
    np.testing.assert_allclose(shown[1:3], [-130, 30 + 130], atol=0.005)


def test_a_candidate_in_the_scene_names_the_pair_and_the_distance():
    verdict = Verdict(Reason.TOOL_COLLISION, Stage.PROPOSE, ("palm", "bin_wall_back"), -0.0342)
    candidate = made_candidate(verdict=verdict)
    assert views.candidate_label(candidate) == (
        "part-1, side-1-1, right\ntool in collision\npalm · bin_wall_back, -34.2 mm"
    )


def made_candidate(*, name: str = "side-1-1", arm: str = "right", verdict: Verdict) -> Candidate:
    T = pose_from_rpy((0, 0, 0))
    return Candidate(0, Grasp(name, T, 0.04, 0.03), arm, T, 0.5, verdict)


def hostile(states, view_of) -> View:
    """A view in which every text that comes from outside is an attack."""
    state = states.fault
    verdict = Verdict(Reason.IN_COLLISION, Stage.GRASP, (EVIL, EVIL), -0.001, note=plain(EVIL))
    plan = replace(
        state.plan,
        note=EVIL,
        notes=(plain(EVIL),),
        detections=tuple(replace(d, part=EVIL) for d in state.plan.detections),
        arms=tuple(replace(arm, grasp=EVIL) for arm in state.plan.arms),
    )
    nearest = replace(state.proof.nearest, problem=plain(EVIL), leg=EVIL, pair=(EVIL, EVIL))
    bad = replace(
        state,
        scan=replace(state.scan, source=EVIL),
        plan=plan,
        proof=replace(state.proof, nearest=nearest, violations=(nearest,)),
        candidates=(made_candidate(name=EVIL, arm=EVIL, verdict=verdict),),
        verdict=verdict,
        seconds=((EVIL, 0.1),),
        approval=replace(state.approval, actor=EVIL),
        receipts=(replace(state.receipts[0], arm=EVIL, sent=EVIL),),
        fault=EVIL,
        message=EVIL,
    )
    return view_of(
        bad,
        live=Live(
            job=0,
            note=EVIL,
            robot=EVIL,
            joints={EVIL: 1.0},
            link=LinkStatus(EVIL, EVIL, 1, 2, EVIL, 1.0, 1.0, 0.1, EVIL),
        ),
    )


def test_nothing_from_outside_becomes_html(cell, states, view_of):
    view = hostile(states, view_of)
    state, buttons = view.state, dict.fromkeys([None, *Reason], "id")
    pages = [
        views.strip_html(state),
        views.status_html(view),
        views.status_html(replace(view, state=replace(state, phase=Phase.SENDING))),
        views.status_html(replace(view, state=replace(states.planning, message=EVIL))),
        views.scan_line(state),
        views.parts_line(state),
        plan_line(state),
        plan_line(replace(state, plan=None)),
        approval_line(state, view.at, ""),
        send_line(state),
        facts_html(state, {}, view.at),
        plan_html(state),
        link_views.link_html(view),
        link_views.joints_html(cell, view.live.joints),
        lanes_html(cell, view.runs, view.plan_seconds),
        now_html(1.0, 2.0, EVIL),
        funnel_html(state.candidates, None, buttons),
        candidates_html(
            state.candidates,
            (0,),
            CandidateOrder(),
            headings=dict.fromkeys(COLUMNS, "id"),
            rows=["id"] * PAGE,
        ),
    ]
    seen = ""
    for page in pages:
        reader = Reader(page)
        assert set(reader.tags) <= TAGS
        for name, value in reader.attributes:
            assert not name.startswith("on") or value.startswith(
                ("document.getElementById('id').click()", "if(event.key===")
            )
            assert name != "src"
        seen += reader.text
    assert EVIL in seen


def test_the_last_study_speaks_for_the_threshold_nearby(states):
    cell = states.idle.cell
    forecasts = (Forecast(0.1, 0.7, 1.0, 0.17, 9.2, 763.2), Forecast(0.2, 0.0, None, None, 9, None))
    said = views.forecast_line(cell, Predictions(cell.digest, 53, forecasts), 0.12)
    assert (
        "53 simulated pairs at 100 mm: 70% far enough apart, 100% planned, in 170 ms, "
        "763 parts per hour" in said
    )
    assert "changed" not in said
    said = views.forecast_line(cell, Predictions("other", 53, forecasts), 0.19)
    assert "Study of an earlier cell, 53 simulated pairs at 200 mm: 0% far enough apart" in said
    assert views.forecast_line(cell, None, 0.2) == ""


def test_the_link_tells_protocol_state_acknowledgement_and_stop(states, view_of):
    link = LinkStatus(
        "abb-socket/2", "running", 3, 12, "0007 ok 0005 ABCD", NOW, NOW - 1.5, 0.25, "after 0.25 s"
    )
    parts = (PartReport("right", 0, True), PartReport("left", 1, False, "closed to 0.0 mm"))
    heard = replace(states.sending.receipts[-1], step=2)
    state = replace(states.sending, part_reports=parts, receipts=(heard,))
    text = Reader(link_views.link_html(view_of(state, live=Live(link=link)))).text
    for expected in (
        "abb-socket/2 (protocol abb-socket/2)",
        f"running, step 2 of {len(state.plan.sequence)}",
        "0007 ok 0005 ABCD",
        "1.5 s ago",
        "after 0.25 s",
        "part-1 picked",
        "part-2 failed: closed to 0.0 mm",
        "It is not a safety function",
    ):
        assert expected in text, expected


def test_the_robots_last_word_is_told_from_the_fault_to_be_acknowledged_here(states, view_of):
    live = Live(robot="fault: stopped by the client")
    for state, here in ((states.fault, states.fault.fault), (states.idle, "none to acknowledge")):
        text = Reader(link_views.link_html(view_of(state, live=live))).text
        assert f"Last report of the robot{live.robot}Fault{here}" in text


def test_what_has_changed_since_the_start_before_is_listed_and_escaped(states):
    assert views.changes_html(states.planning) == ""
    changed = ("numpy 1 is 2 now", "new user <b>Eve</b> (viewer)")
    state = replace(states.planning, changed=changed, changed_since="session x")
    text = Reader(views.changes_html(state)).text
    assert "<b>Eve" not in views.changes_html(state)
    assert "session x" in text and "numpy 1 is 2 now" in text and "Eve" in text
    # Who may come in is no software.
    assert "software" not in text
