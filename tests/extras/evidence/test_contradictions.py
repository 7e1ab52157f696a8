"""Evidence that contradicts itself is found, whoever has signed it and though its chain holds."""

import re
from contextlib import closing
from dataclasses import replace

import pytest
from idle import Idle
from tampering import AT, OURS, PUBLIC, Opened, verified

from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.jobs import JobEnded
from workbench.app.core.cycle.outcomes import AcknowledgeFault
from workbench.app.core.cycle.parts import UseDetections
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.cycle.scanning import UseScan
from workbench.app.core.cycle.sending import LinkEnded, SendPlan
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.core.drop_back import ConfirmHandsEmpty
from workbench.app.records.sessions import new_session
from workbench.app.runtime.bench import Bench
from workbench.extras.evidence import verify
from workbench.journal.journal import Journal


def test_a_sending_without_its_approval_is_found_in_a_chain_that_holds(made, tmp_path):
    one = Opened(made / "bundle.zip")

    def lapsed(number, body):
        return re.sub(rb'"until":\d+', b'"until":1000000000', body)

    one.chain_anew(lapsed)
    one.made_good(OURS)
    code, said = verified(made, one.packed(tmp_path / "bundle.zip"), "--key", PUBLIC)
    assert (code, "its approval did not hold" in said) == (1, True)


def with_a_second_sending(one, between=(), change=lambda body: body):
    """Sent again by the same approval, after entries of these kinds; the chain holds."""
    sending = next(entry for entry in one.entries if entry.kind == "SendPlan")
    last = one.entries[-1]
    number, previous, script = last.number, last.hash, ""
    for kind in (*between, sending.kind):
        number += 1
        body = change(sending.body) if kind == sending.kind else b'{"at": 1795437190}'
        chained = verify.hash_of(previous, number, kind, body, ())
        script += (
            f"INSERT INTO entries (number, kind, body, previous, hash) VALUES ({number}, '{kind}',"
            f" X'{body.hex()}', '{previous}', '{chained}');"
        )
        previous = chained
    one.sql(script)
    one.made_good(OURS)


@pytest.mark.parametrize("between", [(), ("Opened",)])
def test_an_approval_that_is_used_twice_is_found_in_a_chain_that_holds(made, tmp_path, between):
    one = Opened(made / "bundle.zip")
    with_a_second_sending(one, between)
    code, said = verified(made, one.packed(tmp_path / "bundle.zip"), "--key", PUBLIC)
    assert (code, "an approval not given before it, or used" in said) == (1, True), said


def test_an_approval_that_nobody_gave_is_found_in_a_chain_that_holds(made, tmp_path):
    one = Opened(made / "bundle.zip")
    sending = next(entry.number for entry in one.entries if entry.kind == "SendPlan")

    def of_eve(number, body):
        exchanged = body.replace(b'"actor":"demo","at":', b'"actor":"eve","at":')
        return exchanged if number == sending else body

    one.chain_anew(of_eve)
    one.made_good(OURS)
    code, said = verified(made, one.packed(tmp_path / "bundle.zip"), "--key", PUBLIC)
    assert (code, "an approval not given before it, or used" in said) == (1, True), said


def test_an_approval_of_before_a_start_lets_nothing_out(made, tmp_path):
    one = Opened(made / "bundle.zip")
    approve = next(entry.number for entry in one.entries if entry.kind == "Approve")
    one.sql(f"UPDATE entries SET kind = 'Started' WHERE number = {approve - 1};")
    one.chain_anew(lambda number, body: body)
    one.made_good(OURS)
    path = one.packed(tmp_path / "before.zip")
    assert verified(made, path, "--key", PUBLIC)[0] == 0
    one.sql(
        f"UPDATE entries SET kind = 'x', number = 0 WHERE number = {approve};"
        f"UPDATE entries SET number = {approve} WHERE number = {approve - 1};"
        f"UPDATE entries SET kind = 'Approve', number = {approve - 1} WHERE number = 0;"
    )
    one.chain_anew(lambda number, body: body)
    one.made_good(OURS)
    code, said = verified(made, one.packed(tmp_path / "after.zip"), "--key", PUBLIC)
    assert (code, "an approval not given before it, or used" in said) == (1, True), said


@pytest.mark.parametrize("people", [1, 2])
def test_an_honest_session_does_not_contradict_itself(cell, samples, tmp_path, people):
    """Sent, opened again, approved again, and sent again."""
    wanted = replace(cell, approvers=people)
    journal = new_session(tmp_path, wanted, AT)
    journal.close()
    for _ in range(2):
        with closing(Bench(wanted, Journal(journal.folder), effects=Idle)) as bench:
            bench.do(UseScan(samples.scan()), "ada")
            bench.do(UseDetections(samples.detections()), "ada")
            number = bench.do(MakePlan(), "ada").number
            result = samples.planned(bench.state.scene_digest)
            bench.do(JobEnded(number, result), "worker")
            for name in ("ada", "bob")[:people]:
                bench.do(WatchPlan(result.plan.digest), name)
                bench.do(Approve(result.plan.digest), name)
            bench.do(SendPlan(result.plan.digest), "ada")
            bench.do(LinkEnded("it broke"), "robot link")
            bench.do(AcknowledgeFault(), "ada")
            bench.do(ConfirmHandsEmpty(), "ada")
            entries = [
                verify.JournalEntry(
                    row.number, row.kind, row.body, row.files, row.previous, row.hash
                )
                for row in bench.entries()
            ]
    assert [entry.kind for entry in entries].count("SendPlan") == 2
    assert list(verify.chain_problems(entries)) == []
