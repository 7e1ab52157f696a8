"""A recorded session: who did what, which plan was approved and sent, and whether it is all true.

Each entry carries a hash of itself and of the one before, so a later change shows.  Beyond that
every state is computed again from the entries and compared with the one that was recorded.
"""

import time
from collections import Counter
from itertools import groupby
from pathlib import Path

import workbench as wb

EXAMPLE = Path(__file__).resolve().parents[1] / "sessions" / "example"

session = wb.open_session(EXAMPLE)
problems = session.verify()
print(f"{session.count} entries, head {session.head[:12]}")
print("the chain holds" if not problems else "\n".join(problems))

history = list(wb.replay(session))
session.close()
print("every state follows from the entries as it was recorded\n")

# Dozens of messages to the robot follow each other: one line tells of all of them.
for (actor, name), some in groupby(
    history, lambda one: (one[0].actor, type(one[0].command).__name__)
):
    same = list(some)
    entry, state = same[-1]
    at = time.strftime("%H:%M:%S", time.gmtime(entry.at))
    times = f"{name} x {len(same)}" if len(same) > 1 else name
    print(f"{at} {actor:10} {times:12} {state.message}")

print()
for entry, state in history:
    match type(entry.command).__name__, state.approval:
        case "Approve", wb.Approval() as approval:
            print(f"approved: plan {approval.plan_digest[:12]} by {', '.join(approval.people)}")
        case "SendPlan", wb.Approval() as approval:
            print(f"sent:     plan {approval.plan_digest[:12]} by {entry.actor}")
        case _:
            pass
outcomes = Counter("picked" if one.is_picked else "lost" for one in history[-1][1].outcomes)
print("parts:   ", ", ".join(f"{count} {word}" for word, count in outcomes.items()))
