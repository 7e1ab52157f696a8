"""One plan, approved and sent again and again to the twin of Universal Robots, by `ur-rtde`.

`PYTHONPATH=.:tests:tests/devices python tests/devices/universal_robots/soak_link.py --cycles 1000`

Each cycle is a sending of its own: a client that connects, a program, its receipts, its end.  Every
line says what was seen so far.  It ends with 1 as soon as a program is lost or runs twice, or a
receipt is missing, doubled or out of order.  It is no part of the suite: it takes an hour.
"""

import argparse
import gc
import os
import time
from pathlib import Path
from statistics import median, quantiles

from twins import PATIENT, own_host, planned_for, twin_of

import workbench
from workbench.model.errors import LinkError
from workbench.plugins.robot_link import send

TOLD = 100
"""[cycles] Between two lines."""


def memory() -> float:
    """What this process holds [MB]."""
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def opened() -> int:
    """How many files, pipes and sockets this process has open."""
    return len(list(Path("/proc/self/fd").iterdir()))


def main() -> int:
    """Send until all is done or something is wrong."""
    asked = argparse.ArgumentParser(description=__doc__)
    asked.add_argument("--cycles", type=int, default=1000)
    asked.add_argument("--link", default="ur-rtde")
    asked.add_argument("--speed", type=float, default=50.0)
    given = asked.parse_args()
    cell, plan, proof = planned_for(given.link)
    legs = [leg for step in plan.sequence for _, leg in step.runs]
    expected = ["program", *legs, "end"]
    took: list[float] = []
    ended, failed, receipts = 0, 0, 0
    with twin_of(cell, own_host(), speed=given.speed) as (twin, there):
        for cycle in range(1, given.cycles + 1):
            approval = workbench.approve(cell, plan, proof, f"cycle {cycle}")
            began, kinds, sent = time.monotonic(), [], ""
            twin.programs.clear()
            try:
                for receipt in send(plan, approval, there, patience=PATIENT):
                    kinds.append(receipt.kind)
                    sent = sent or receipt.sent
            except LinkError as error:
                failed += 1
                print(f"cycle {cycle}: {error}; receipts {kinds}", flush=True)
            receipts += len(kinds)
            ours = [text for text in twin.programs if "workbench_plan" in text]
            if len(ours) > 1 or (kinds and (kinds != expected[: len(kinds)] or ours != [sent])):
                print(f"cycle {cycle}: {len(ours)} programs came, receipts {kinds}", flush=True)
                return 1
            ended += kinds == expected
            took.append(time.monotonic() - began)
            if cycle % TOLD == 0 or cycle == given.cycles:
                gc.collect()
                most = quantiles(took[-TOLD:], n=20)[-1] if len(took) > 1 else took[-1]
                print(
                    f"{cycle} cycles by {given.link}: {ended} ended, {failed} failed, "
                    f"{receipts} receipts; a cycle {median(took[-TOLD:]):.2f} s, 95 % "
                    f"{most:.2f} s; {memory():.1f} MB, {opened()} files open",
                    flush=True,
                )
    return int(failed > 0)


if __name__ == "__main__":
    raise SystemExit(main())
