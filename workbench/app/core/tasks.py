"""How a task of the worker begins."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from workbench.app.core.command import Entry
from workbench.app.core.effects import StartJob
from workbench.app.core.state import Job, State, without_approval
from workbench.model.messages.message import Message

Begun = tuple[State, tuple[StartJob, ...]]
"""The state, and the task that has begun with it, if one has."""


def begin_task(
    state: State,
    entry: Entry,
    name: str,
    arguments: Mapping[str, Any],
    message: Message | str,
    **about: Any,
) -> Begun:
    """A job begins; `about` goes into the `Job`, for when it ends."""
    job = Job(state.number, name, entry.at, **about)
    after = replace(without_approval(state), job=job, message=message)
    return after, (StartJob(job.number, name, arguments),)
