"""Where a plan comes nearest to something: said in words, and shown at a click."""

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from html import escape

import numpy as np

from workbench.app.core.state import Phase, State
from workbench.app.picking.facts import nearest_of, nearest_place
from workbench.formats.plans.certificates import certificate_bytes
from workbench.gui.scene.measure import clear_way
from workbench.gui.shared.own import Visited
from workbench.gui.shared.playback import Run, moments, timeline
from workbench.gui.shared.tables import clickable
from workbench.gui.shared.views import line, short, table_html
from workbench.gui.shared.visitor import Visitor
from workbench.gui.texts.cycle import CyclePageText
from workbench.gui.texts.labels import LabelText
from workbench.gui.texts.scene import NearestText
from workbench.model.cell import MOST_PICKS
from workbench.model.derived.row_parts import label_in
from workbench.model.messages.message import Message, found_part
from workbench.model.messages.plans import leg_message
from workbench.model.motion import SLOT_LEGS, floor_distance
from workbench.model.plan import Plan, Proof, Proven
from workbench.proof.claims.clearance import linear_clearance
from workbench.proof.claims.spot import Spot
from workbench.proof.claims.stages import NEAR_MARGIN_LEGS

NEAR_BY = 0.45
"""[m] From this far off two bodies are viewed."""

TOUCH = 0.0001
"""[m] Bodies that are nearer than this touch, for people."""

ROUNDING = 1e-6
"""[m] A bound that misses its margin by less keeps it, for people."""


def free_message(state: State) -> Message:
    """The smallest clearance on free legs of all that is to be carried out, with its place."""
    row = state.whole_row
    number = nearest_of(row)
    return _of_plan(row, number, _nearest_message(state, row[number].plan, row[number].proof))


def straight_lines(state: State) -> list[tuple[str, Message]]:
    """The line about linear motions, or about a hand among the parts; none on a path to a view."""
    if all(plan.is_view_plan for plan in state.plans):
        return []
    name = "Among the parts" if any(plan.is_stir_plan for plan in state.plans) else "Linear motion"
    return [(name, straight_message(state))]


def straight_message(state: State) -> Message:
    """How near hand and part come on the linear motions of all that is to be carried out."""
    row = state.whole_row
    bounds = [linear_clearance(proven_plan.proof) for proven_plan in row]
    number = min(range(len(row)), key=lambda place: _or_far(bounds[place]))
    return _of_plan(row, number, _straight_message(state, row[number].proof))


def comes_too_near(state: State) -> bool:
    """Whether a linear motion of what is to be carried out is bounded below its near margin."""
    margin = state.cell.policy.near_margin - ROUNDING
    return any(_or_far(linear_clearance(plan.proof)) < margin for plan in state.whole_row)


def _or_far(bound: float | None) -> float:
    return math.inf if bound is None else bound


def _of_plan(row: Sequence[Proven], number: int, text: Message) -> Message:
    """What is said of one plan, with its number where there are others."""
    return NearestText.OF_PLAN(number=number + 1, text=text) if len(row) > 1 else text


def _nearest_message(state: State, plan: Plan, proof: Proof) -> Message:
    """The smallest clearance on free legs with its place: how near, when, which leg, what."""
    place, distance = proof.nearest, LabelText.AT_LEAST(distance=floor_distance(proof.clearance))
    if place is None or place.pair is None:
        return NearestText.FROM_EVERYTHING(distance=distance)
    # Parts by the numbers of the scan, that of the first plan.
    first, second = (label_in(body, state.plans[0], plan.detections) for body in place.pair)
    args = {
        "distance": distance,
        "arm": place.arm,
        "leg": leg_message(place.leg),
        "first": found_part(first),
        "second": found_part(second),
    }
    spot = nearest_place(state.cell, plan, proof)
    if spot is None:
        return NearestText.PLACE(**args)
    runs = _runs_of(state, plan)
    run = _run(runs, place.arm, place.leg)
    time, others = run.start + spot.seconds, _others(runs, run, spot)
    if others:
        return NearestText.PLACE_IF(**args, time=time, others=others)
    return NearestText.PLACE_AT(**args, time=time)


def _straight_message(state: State, proof: Proof) -> Message:
    """How near hand and part come on their linear motions, where they may come near."""
    margin = state.cell.policy.near_margin
    kept = [
        (float(bounds.min()), arm, leg)
        for arm, leg, bounds in proof.clearances
        if leg in NEAR_MARGIN_LEGS
    ]
    if not kept:
        return NearestText.REQUIRED(margin=margin)
    bound, arm, leg = min(kept)
    near = LabelText.AT_LEAST(distance=floor_distance(bound))
    if bound < TOUCH:
        near = LabelText.TOUCHING()
    text = NearestText.AT_SLOT if leg in SLOT_LEGS else NearestText.LINEAR
    return text(
        near=near, arm=arm, leg=leg_message(leg), margin=margin, resolution=proof.resolution
    )


def go_html(text: str, button: str, tip: str) -> str:
    """Text that presses an unseen button when it is clicked."""
    return f'<span class="wb-go" title="{escape(tip)}" {clickable(button)}>{escape(text)}</span>'


def proof_html(state: State, links: "PlanLinks") -> str:
    """What was proven of a plan or of a row, in three lines; place and certificates are clicked."""
    for number, proven_plan in enumerate(state.whole_row):
        if not proven_plan.proof.holds:
            fails = CyclePageText.PROOF_FAILS(violation=proven_plan.proof.violations[0].message)
            text = _of_plan(state.whole_row, number, fails)
            return line(links.render(text), kind="bad")
    name, certificates = certificates_of(state)
    rows = [
        ("Free motion", links.render(free_message(state))),
        *((name, links.render(text)) for name, text in straight_lines(state)),
        (name, ", ".join(map(links.render, certificates))),
    ]
    return table_html(rows, made=links.make_html(state))


def certificates_of(state: State) -> tuple[str, tuple[Message, ...]]:
    """Name of the line from which certificates are saved, and what each of them is called there."""
    row = state.whole_row
    if len(row) == 1:
        digest = short(row[0].plan.digest)
        return "Certificate", (NearestText.CERTIFICATE(digest=digest),)
    numbers = range(1, len(row) + 1)
    return "Certificates", tuple(NearestText.PLANS(number=number) for number in numbers)


class PlanLinks:
    """What a click on the facts of a plan or a row does: shows the place, saves a certificate.

    Concurrency: any thread.
    """

    def __init__(
        self,
        visitor: Visitor,
        before: Callable[[], None] = lambda: None,
        plans: int = MOST_PICKS,
    ):
        """Add unseen buttons where the page is built now.

        Args:
            visitor: whose page it is.
            before: called as the place is asked for.
            plans: this many at most.
        """
        self._visitor = visitor
        self._before = before
        self._nearest = visitor.unseen(self._go)
        self._certificates = [visitor.unseen(partial(self._save, index)) for index in range(plans)]
        visitor.hide((self._nearest, *self._certificates))

    def make_html(self, state: State) -> Mapping[str, str]:
        """HTML of what can be clicked, by the names of the lines that it stands in."""
        name, certificates = certificates_of(state)
        saves = zip(map(self.render, certificates), self._certificates, strict=False)
        free = self.render(free_message(state))
        tip = "Saves what another machine can check"
        return {
            "Free motion": go_html(free, self._nearest, "Shows the plan there"),
            name: ", ".join(go_html(text, button, tip) for text, button in saves),
        }

    def render(self, message: Message) -> str:
        """A message in the language of who looks."""
        return self._visitor.words.render(message)

    def _go(self) -> None:
        visitor, state = self._visitor, self._visitor.bench.state
        row = state.whole_row
        if not row or state.phase is Phase.SENDING:
            return
        nearest = row[nearest_of(row)]
        plan, proof = nearest.plan, nearest.proof
        if proof.nearest is None:
            return
        spot = nearest_place(state.cell, plan, proof)
        if spot is None:
            visitor.notify("Nothing to show", "on its free legs the plan comes near nothing")
            return
        self._before()
        run = _run(_runs_of(state, plan), proof.nearest.arm, proof.nearest.leg)
        runs, time = timeline(*state.plans), run.start + spot.seconds
        visitor.own.end()
        visitor.look.change(time=time, is_playing=False, by=None)
        near = visitor.words.render(LabelText.AT_LEAST(distance=floor_distance(proof.clearance)))
        visitor.own.change(visited=Visited(plan, time, spot, near))
        first, second = spot.points
        q = {arm: moment.q for arm, moment in moments(state.cell, runs, time).items()}
        middle = (first + second) / 2
        side = clear_way(middle, second - first, NEAR_BY, state.cell, q)
        camera = visitor.client.camera
        with visitor.client.atomic():
            camera.position = middle + NEAR_BY * side
            camera.look_at = middle

    def _save(self, number: int) -> None:
        row = self._visitor.bench.state.whole_row
        if number >= len(row) or not row[number].proof.holds:
            return
        plan = row[number].plan
        content = certificate_bytes(plan, plan.scene, row[number].proof)
        name = f"certificate-{short(plan.digest)}.json"
        self._visitor.client.send_file_download(name, content, save_immediately=True)


def _runs_of(state: State, plan: Plan) -> tuple[Run, ...]:
    """The legs of one plan of the row, on the clock of the whole row."""
    row = state.plans
    place = next((place for place, proven_plan in enumerate(row) if proven_plan is plan), None)
    if place is None:
        return timeline(plan)
    return tuple(run for run in timeline(*row) if run.plan == place)


def _run(runs: tuple[Run, ...], arm: str, leg: str) -> Run:
    return next(run for run in runs if (run.arm, run.leg.name) == (arm, leg))


def _others(runs: tuple[Run, ...], run: Run, spot: Spot) -> list[Message]:
    """Where another arm is meanwhile, if that is not where the plan has it then."""
    found: list[Message] = []
    for other in runs:
        if other.start != run.start or other.arm == run.arm:
            continue
        seconds = spot.others.get(other.arm, 0.0)
        if not np.isclose(seconds, min(spot.seconds, other.leg.seconds)):
            found.append(NearestText.OTHER_ARM(arm=other.arm, time=other.start + seconds))
    return found
