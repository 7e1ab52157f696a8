"""Where a plan comes nearest to something: said in words, and shown at a click."""

from collections.abc import Callable
from html import escape

import numpy as np

from workbench.app.core.state import Phase, State
from workbench.app.picking.facts import nearest_place
from workbench.formats.plans.certificates import certificate_bytes
from workbench.gui.scene.measure import clear_way
from workbench.gui.shared.own import Visited
from workbench.gui.shared.playback import Run, moments, timeline
from workbench.gui.shared.tables import clickable
from workbench.gui.shared.views import line, mm, short, table_html
from workbench.gui.shared.visitor import Visitor
from workbench.model.plan import Plan, Proof, at_least
from workbench.proof.spot import Spot
from workbench.proof.stages import STRAIGHT

NEAR_BY = 0.45
"""[m] From so far off two bodies are looked at."""

TOUCH = 0.0001
"""[m] Bodies that are nearer than this touch, for people."""


def nearest_words(state: State, plan: Plan, proof: Proof) -> str:
    """The smallest clearance on free legs with its place: how near, when, which leg, what."""
    place = proof.nearest
    if place is None or place.pair is None:
        return f"{at_least(proof.clearance)} from everything"
    words = f"{at_least(proof.clearance)}, {place.arm} arm on {place.leg}"
    spot = nearest_place(state.cell, plan, proof)
    if spot is not None:
        runs = _runs_of(state, plan)
        run = _run(runs, place.arm, place.leg)
        words += f" at {run.start + spot.seconds:.2f} s{_others(runs, run, spot)}"
    return f"{words}: {place.pair[0]} and {place.pair[1]}"


def straight_words(state: State, proof: Proof) -> str:
    """How near hand and part come on their straight ways, where they may come near."""
    asked = f"{mm(state.cell.policy.near_margin)} asked"
    kept = [
        (float(bounds.min()), arm, leg) for arm, leg, bounds in proof.clearances if leg in STRAIGHT
    ]
    if not kept:
        return asked
    bound, arm, leg = min(kept)
    near = "touching" if bound < TOUCH else at_least(bound)
    within = f"met to within {mm(proof.resolution)}"
    return f"{near}, {arm} arm on {leg} ({asked}, {within}; not of the part taken and its bed)"


def go_html(text: str, button: str, tip: str) -> str:
    """Text that presses an unseen button when it is clicked."""
    return f'<span class="wb-go" title="{escape(tip)}" {clickable(button)}>{escape(text)}</span>'


def proof_html(state: State, plan: Plan, proof: Proof, links: "PlanLinks") -> str:
    """What was proven of a plan, in three lines; its place and its certificate can be clicked."""
    if not proof.holds:
        return line(f"The proof does not hold: {proof.violations[0]}", kind="bad")
    near, ways = nearest_words(state, plan, proof), straight_words(state, proof)
    name = f"certificate-{short(plan.digest)}.json"
    rows = [("Free ways", near), ("Straight ways", ways), ("Certificate", name)]
    made = {
        "Free ways": go_html(near, links.nearest, "Shows the plan there"),
        "Certificate": go_html(name, links.certificate, "Saves what another machine can check"),
    }
    return table_html(rows, made=made)


class PlanLinks:
    """What a click on a plan's facts does: the place is shown, the certificate is saved.

    Concurrency: any thread.
    """

    def __init__(self, visitor: Visitor, before: Callable[[], None] = lambda: None):
        """Add unseen buttons where the page is built now; `before` is called as one is pressed."""
        self._visitor = visitor
        self._before = before
        self.nearest = visitor.unseen(self._go)
        self.certificate = visitor.unseen(self._save)
        visitor.hide((self.nearest, self.certificate))

    def _go(self) -> None:
        visitor, state = self._visitor, self._visitor.bench.state
        plan, proof = state.plan, state.proof
        if plan is None or proof is None or proof.nearest is None or state.phase is Phase.SENDING:
            return
        spot = nearest_place(state.cell, plan, proof)
        if spot is None:
            visitor.tell("Nothing to show", "on its free legs the plan comes near nothing")
            return
        self._before()
        run = _run(_runs_of(state, plan), proof.nearest.arm, proof.nearest.leg)
        runs, time = timeline(*state.plans), run.start + spot.seconds
        visitor.own.end()
        visitor.look.change(time=time, is_playing=False, by=None)
        visitor.own.change(visited=Visited(plan, time, spot, at_least(proof.clearance)))
        first, second = spot.points
        q = {arm: moment.q for arm, moment in moments(state.cell, runs, time).items()}
        middle = (first + second) / 2
        side = clear_way(middle, second - first, NEAR_BY, state.cell, q)
        camera = visitor.client.camera
        with visitor.client.atomic():
            camera.position = middle + NEAR_BY * side
            camera.look_at = middle

    def _save(self) -> None:
        state = self._visitor.bench.state
        if state.plan is None or state.proof is None or not state.proof.holds:
            return
        content = certificate_bytes(state.plan, state.plan.scene, state.proof)
        name = f"certificate-{short(state.plan.digest)}.json"
        self._visitor.client.send_file_download(name, content, save_immediately=True)


def _runs_of(state: State, plan: Plan) -> tuple[Run, ...]:
    """The legs of one plan of the row, on the clock of the whole row."""
    row = state.plans
    place = next((place for place, one in enumerate(row) if one is plan), None)
    if place is None:
        return timeline(plan)
    return tuple(run for run in timeline(*row) if run.plan == place)


def _run(runs: tuple[Run, ...], arm: str, leg: str) -> Run:
    return next(run for run in runs if (run.arm, run.leg.name) == (arm, leg))


def _others(runs: tuple[Run, ...], run: Run, spot: Spot) -> str:
    """Where another arm is meanwhile, if that is not where the plan has it then."""
    said = ""
    for other in runs:
        if other.start != run.start or other.arm == run.arm:
            continue
        seconds = spot.others.get(other.arm, 0.0)
        if not np.isclose(seconds, min(spot.seconds, other.leg.seconds)):
            said += f" if the {other.arm} arm is then where it should be at "
            said += f"{other.start + seconds:.2f} s"
    return said
