"""Plans bent by the thousand, proven and judged, one line of JSON each, and a table of those lines.

```
PYTHONPATH=.:tests/planning python tests/proof/bend_many.py yumi tx2_90 --count 400 --seed 30000 \\
    --made FOLDER --out bent.jsonl
PYTHONPATH=.:tests/planning python tests/proof/bend_many.py --table bent.jsonl
```

Cells that are not shipped are made in the folder.  The same seed bends the same plans anywhere.
"""

import argparse
import json
import re
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from bends import KINDS, bent
from bent_cells import PILES, cases
from judge import Judge
from judge_motion import ALIKE

from workbench.model.messages.proofs import ProofText
from workbench.proof.claims.prove import prove
from workbench.proof.claims.timing.pace import pace_violations

A_PLAN = 25
"""So many bends of each plan."""

CLOSER = (("nearly", ALIKE), ("at the limit", -ALIKE), ("close by", -0.0005))
"""What the judge calls a plan that the proof alone refuses, when it leaves so much less [m]."""

SLOWER = (0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0)
"""By these shares a plan whose times alone are refused is made slower, until they hold."""

Line = dict[str, Any]


def judged(case, seed, bends):
    """A good plan and bent ones: what was bent, its proof, what the judge says, and the case."""
    judge = Judge()
    for number in range(-1, bends):
        what, other = "nothing", case
        if number >= 0:
            what, other = bent(case, np.random.default_rng([seed, number]))
        proof = prove(other.cell, other.scene, other.plan)
        yield what, proof, judged_by(judge, other), other


def judged_by(judge: Judge, case):
    """Why the judge refuses a case, None where it finds nothing."""
    return judge.refusal(case.files, case.scene, case.plan)


def how_close(case) -> str:
    """What a judge says who leaves less and less, of a plan that the proof alone refuses."""
    for word, beyond in CLOSER:
        if judged_by(Judge(beyond), case) is not None:
            return word
    return "clear"


def how_slow(case) -> str:
    """By how much a plan has to be slower, for the proof to find a motion that keeps its times."""
    for share in SLOWER:
        if not any(pace_violations(case.cell, slowed(case.plan, 1 + share))):
            return f"{100 * share:g} % slower"
    return "never"


def slowed(plan, factor: float):
    """A plan with all of its times longer."""
    arms = [
        replace(one, legs=tuple(replace(leg, t=leg.t * factor) for leg in one.legs))
        for one in plan.arms
    ]
    return replace(plan, arms=tuple(arms))


def why_alone(case, proof) -> str:
    """What becomes of a plan that the proof alone refuses, by how little it misses."""
    if all(
        one.problem.text in (ProofText.TOO_FAST, ProofText.TOO_HARD) for one in proof.violations
    ):
        return how_slow(case)
    return how_close(case)


def lines(name: str, seed: int, count: int, made: Path) -> Iterator[Line]:
    """At least `count` bent plans of a cell, and the good ones that they come of."""
    number = 0
    while number < count:
        for case in cases(name, [seed], made):
            begin = time.process_time()
            for k, (what, proof, refusal, other) in enumerate(judged(case, seed, A_PLAN), -1):
                line = {"cell": name, "seed": seed, "bend": k, "kind": what}
                line |= {"holds": proof.holds, "judge": refusal is None}
                line["overlaps"] = is_overlapped(case.plan)
                if refusal is not None:
                    line["refusal"] = f"{refusal.why}, {refusal.distance * 1000:.3f} mm"
                    line["refusal"] += f" of {refusal.need * 1000:.3f}, {refusal.legs}"
                if proof.violations:
                    line["violation"] = str(proof.violations[0])
                if refusal is None and not proof.holds:
                    line["says"] = why_alone(other, proof)
                yield line | {"seconds": round(time.process_time() - begin, 3)}
                begin = time.process_time()
            number += A_PLAN
        seed += 1


def is_overlapped(plan) -> bool:
    """Whether the second arm of an alternated plan sets out while the first goes home."""
    return plan.strategy == "alternated" and any(len(step.runs) > 1 for step in plan.sequence)


VERDICTS = ("both hold", "both refuse", "held, the judge refuses", "refused, the judge holds")


def verdict(line: Line) -> str:
    """One of `VERDICTS`."""
    if line["holds"] == line["judge"]:
        return VERDICTS[0] if line["holds"] else VERDICTS[1]
    return VERDICTS[2] if line["holds"] else VERDICTS[3]


def reason(line: Line) -> str:
    """What the proof says, without names and figures, and by how little it does."""
    words = re.sub(r"^(arm \S+ )?(leg \S+ )?(after waypoint \d+)?:? ?", "", line["violation"])
    words = re.sub(r"[-\d.]+ mm: .*", "so much", words)
    return f"{re.sub(r'[-]?[0-9][0-9.]*', '#', words)}; {line['says']}"


def table(said: list[Line]) -> None:
    """Print counts by cell, by kind, and of what the proof alone refuses, by its reason."""
    for title, key in (("cell", "cell"), ("kind", "kind")):
        print(f"{title:18}", *(f"{word:>26}" for word in ("bent", *VERDICTS)))
        for name in dict.fromkeys(line[key] for line in said):
            of = [line for line in said if line[key] == name]
            counts = Counter(map(verdict, of))
            print(f"{name:18}", *(f"{n:26}" for n in (len(of), *(counts[v] for v in VERDICTS))))
        print()
    print(
        "kinds that did not come:", *({kind.__name__ for kind in KINDS} - {s["kind"] for s in said})
    )
    for k in (2, 3):
        of = [line for line in said if verdict(line) == VERDICTS[k]]
        print(f"{VERDICTS[k]}: {len(of)} of {len(said)}")
        classes = Counter(line["refusal"] if k == 2 else reason(line) for line in of)
        for words, count in classes.most_common():
            print(f"{count:6}  {words}")


def main() -> None:
    """As the module says."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("cells", nargs="*", choices=[*PILES, []], help="whose plans are bent")
    options.add_argument("--count", type=int, default=100, help="of bent plans of each cell")
    options.add_argument("--seed", type=int, default=0, help="of the first pile of each cell")
    options.add_argument("--made", type=Path, help="where cells are made that are not shipped")
    options.add_argument("--out", type=Path, help="a file to which lines are appended")
    options.add_argument("--table", type=Path, help="print the table of such a file, and no more")
    typed = options.parse_args()
    if typed.table is not None:
        with typed.table.open(encoding="utf-8") as file:
            said = [json.loads(line) for line in file]
        table([line for line in said if line["kind"] != "nothing"])
        return
    said = []
    for name in typed.cells:
        # Each cell has seeds of its own, so that not all are bent alike.
        first = typed.seed + 1000 * list(PILES).index(name)
        for line in lines(name, first, typed.count, typed.made):
            said.append(line)
            if typed.out is not None:
                with typed.out.open("a", encoding="utf-8") as file:
                    file.write(json.dumps(line) + "\n")
    table([line for line in said if line["kind"] != "nothing"])


if __name__ == "__main__":
    main()
