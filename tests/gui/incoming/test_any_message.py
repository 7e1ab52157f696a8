"""Whatever browsers send: what their page does not offer changes nothing, and leaves no trace."""

import asyncio
import contextlib
import logging
import random
import time

import pytest
from front_page import open_front
from prepared_bench import Canned, Results
from shown_page import CHOICE, FILE, TEXT, USED
from sitter import PASSWORD, PEOPLE, sitting
from waiting import PATIENCE, wait_until

from workbench.app.core.cycle.jobs import JobEnded
from workbench.app.core.cycle.parts import FindParts
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.cycle.scanning import TakeScan
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.core.effects import StartJob
from workbench.app.core.people import WORKER, Role
from workbench.app.core.state import Phase
from workbench.app.runtime.bench import Bench
from workbench.journal.journal import Journal
from workbench.model.errors import InputError
from workbench.web.access.store import Store
from workbench.web.access.users import Users

EACH = 240
"""Messages of one person in one run; there are three people, and two runs."""


class Answering(Canned):
    """Machines that answer at once; what they have no answer for fails."""

    def _answer(self, effect):
        if isinstance(effect, StartJob) and not self._knows(effect):
            self._do(JobEnded(effect.number, InputError("nobody does that here")), WORKER)
        else:
            super()._answer(effect)

    def _knows(self, job):
        if job.name == "plan":
            return job.arguments["detections"] == self._results.detections
        return job.name in ("scan", "localize")

    def ask(self, question):
        """Nothing is told while something is dragged."""


@pytest.fixture
def planned(cell, scan, detections, result, tmp_path, monkeypatch):
    """A bench with a plan that was watched; what is written is written beside it."""
    monkeypatch.chdir(tmp_path)
    results = Results(cell, scan, detections, result)
    effects = lambda _, do, now: Answering(results, do)  # noqa: E731
    bench = Bench(cell, Journal(tmp_path / "session"), effects=effects)
    for command, phase in (
        (TakeScan(0, 2), Phase.SCANNED),
        (FindParts(0), Phase.LOCALIZED),
        (MakePlan(threshold=cell.policy.threshold), Phase.PLANNED),
    ):
        bench.do(command, "Edda", Role.ENGINEER)
        wait_until(lambda phase=phase: bench.state.phase is phase)
    bench.do(WatchPlan(bench.state.plan.digest), "Edda", Role.ENGINEER)
    yield bench
    bench.close()


@pytest.fixture
def opened(planned, tmp_path):
    """The page of the bench behind the front, and the users."""
    file = tmp_path / "users.sqlite"
    store = Store(file)
    for name, role in PEOPLE.items():
        Users(store).add(name, role, PASSWORD)
    front, *closed = open_front(planned, file)
    page = closed[-1]
    yield front, page
    for one in closed:
        one.close()
    store.close()


def still_offers(page, handles):
    """Whether all values that the server holds for a browser are such as its page offers."""
    found = []
    for uuid, shown in page.widgets.items():
        handle = handles.get(uuid)
        if handle is None or shown.kind == FILE or shown.kind not in USED:
            continue
        value, shape = handle.value, shown.shape
        label = shape["label"]
        if shown.kind == CHOICE and value not in handle.options:
            found.append((label, value))
        if shown.kind == TEXT and (type(value) is not str or "\0" in value or len(value) > 1000):
            found.append((label, value))
        numbers = value if isinstance(value, tuple) else (value,)
        for number in numbers if "precision" in shape else ():
            low, high = (shape[one] if shape[one] is not None else number for one in ("min", "max"))
            is_low, is_high = (isinstance(one, tuple | list) for one in (low, high))
            if not (is_low or is_high or low <= number <= high):
                found.append((label, value))
    return found


@pytest.mark.extensive
@pytest.mark.parametrize("order", [("Edda", "Otto", "Vera"), ("Otto", "Vera", "Edda")])
def test_what_no_page_offers_is_not_done_and_leaves_no_trace(
    planned, opened, order, caplog, capfd, monkeypatch
):
    front, page = opened
    rng = random.Random(41)
    done, do = [], planned.do

    def noted(command, actor, role=Role.ENGINEER, *more, **named):
        answer = do(command, actor, role, *more, **named)
        done.append((type(command), actor, role))
        return answer

    monkeypatch.setattr(planned, "do", noted)
    caplog.set_level(logging.INFO)

    async def look():
        async with contextlib.AsyncExitStack() as stack:
            sitters = []
            for name in order:
                sitters.append(await stack.enter_async_context(sitting(front, name)))
                await sitters[-1].open_more()
            await asyncio.sleep(0.5)  # what was opened has been drawn
            recorded, seen = len(done), page._renderer._look.now

            # First only what no page offers: nothing is recorded, nothing is seen otherwise.
            async def attack(sitter):
                others = [one.page for one in sitters if one is not sitter]
                for _ in range(EACH // 2):
                    await sitter.send_wrong(rng, others)

            await asyncio.gather(*map(attack, sitters))
            for sitter in sitters:
                await heard(sitter)
            assert done[recorded:] == []
            assert page._renderer._look.now == seen

            # Then among what they do offer, and in whatever state that leads to.
            async def mix(sitter):
                others = [one.page for one in sitters if one is not sitter]
                for _ in range(EACH // 2):
                    if rng.random() < 0.5:
                        await sitter.use(rng)
                    else:
                        await sitter.send_wrong(rng, others)

            await asyncio.gather(*map(mix, sitters))
            for sitter in sitters:
                await heard(sitter)
            return sum(sitter.sent for sitter in sitters)

    async def heard(sitter):
        field, asked = await sitter.confirm()
        visitors = page._renderer._visitors

        def has_come():
            return any(
                (widget := visitor.gui._gui_input_handle_from_uuid.get(field)) is not None
                and widget.value == asked
                for visitor in tuple(visitors.values())
            )

        await sitter.until(has_come)
        (handles,) = (
            one.gui._gui_input_handle_from_uuid
            for one in tuple(visitors.values())
            if field in one.gui._gui_input_handle_from_uuid
        )
        assert still_offers(sitter.page, handles) == []

    sent = asyncio.run(asyncio.wait_for(look(), PATIENCE))
    assert sent >= 3 * EACH
    for command, actor, role in done:
        if actor in PEOPLE:
            assert role is PEOPLE[actor]
            assert role.covers(command.right.role), (command, actor)
    time.sleep(0.5)  # threads that were begun by the last messages
    written = "".join(capfd.readouterr()) + caplog.text
    assert "Traceback" not in written, written[written.index("Traceback") - 200 :][:3000]
    assert "refused value" in caplog.text
