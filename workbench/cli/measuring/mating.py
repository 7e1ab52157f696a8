"""`workbench study mating`: how often parts mate, against physics."""

from dataclasses import asdict

from workbench.app.core.value_checks import SEED_LIMIT
from workbench.app.runtime.readiness import make_ready
from workbench.cli.arguments.studies import StudyMating
from workbench.cli.exits import SUCCESS
from workbench.cli.terminal import check_number, check_whole, print_json, print_table, progress
from workbench.model.errors import InputError
from workbench.perception.simulation.inserting import Push
from workbench.plugins.progress import within
from workbench.studies.mating import Inserts, Mated, insert_parts

MOST_INSERTIONS = 1_000_000


def study_mating(typed: StudyMating) -> int:
    """Carry it out and print what was found."""
    check_whole("--insertions", typed.insertions, 1, MOST_INSERTIONS)
    check_whole("--seed", typed.seed, 0, SEED_LIMIT - 1 - 3 * MOST_INSERTIONS)
    check_number("--wider", typed.wider, 0.0, 100.0)
    check_number("--force", typed.force, 1.0, 1000.0)
    check_number("--friction", typed.friction, 0.0, 2.0)
    check_number("--stiffness", typed.stiffness, 0.1, 1000.0)
    if not typed.joints:
        raise InputError("--joints needs at least one value")
    push = Push(typed.force, typed.friction, typed.stiffness * 1000)
    about = (typed.insertions, typed.seed, typed.wider, typed.rigid, push, typed.look_again)
    with progress("mating") as report:
        make_ready(report, ("planning", "seeing"))
        done = [
            insert_parts(
                Inserts(typed.cell, joint, *about),
                within(report, number / len(typed.joints), (number + 1) / len(typed.joints)),
            )
            for number, joint in enumerate(typed.joints)
        ]
    if typed.json:
        print_json({"joints": [asdict(mated) for mated in done]})
        return SUCCESS
    print_table(
        "The share of parts that mate: by their error budgets, by the rule for the errors drawn, "
        "and by physics",
        ("joint", "insertions", "predicted", "by rule", "measured", "apart", "not as by rule"),
        [_words(mated) for mated in done],
    )
    for mated in done:
        if mated.believed is not None:
            unseen = f"; {mated.unseen} bases were not seen" if mated.unseen else ""
            print(f"{mated.pair}: {mated.believed:.1%} predicted without looking again{unseen}")
    return SUCCESS


def _words(mated: Mated) -> tuple[str, ...]:
    shares = (mated.predicted, mated.by_rule, mated.measured)
    return (
        mated.pair,
        str(mated.count),
        *(f"{share:.1%}" for share in shares),
        f"{mated.predicted - mated.measured:+.3f}",
        f"{mated.otherwise:.1%}",
    )
