import dataclasses
import itertools

import pytest

from workbench.app.core.state import SessionState, State, begin_stage

STAGES = [kind for kind in reversed(State.__mro__) if issubclass(kind, SessionState)]


def own_fields(stage):
    earlier = {one.name for one in dataclasses.fields(SessionState)}
    if stage is not SessionState:
        earlier = {one.name for one in dataclasses.fields(stage.__base__)}
    return {one.name for one in dataclasses.fields(stage)} - earlier


def full_state(cell):
    """A state in which nothing is as at the beginning."""
    return State(**{one.name: object() for one in dataclasses.fields(State)} | {"cell": cell})


@pytest.mark.parametrize("stage", STAGES[1:])
def test_what_begins_anew_takes_itself_and_all_later_stages_along_and_nothing_else(cell, stage):
    state, first = full_state(cell), State(cell)
    after = begin_stage(state, stage)
    void = set().union(*(own_fields(one) for one in STAGES[STAGES.index(stage) :]))
    for one in dataclasses.fields(State):
        expected = first if one.name in void else state
        assert getattr(after, one.name) is getattr(expected, one.name), one.name


def test_every_field_belongs_to_one_stage():
    stated = [name for stage in STAGES for name in stage.__annotations__]
    assert len(stated) == len(set(stated))
    assert set(stated) == {one.name for one in dataclasses.fields(State)}
    assert all(one.__bases__ == (before,) for before, one in itertools.pairwise(STAGES))


def test_what_is_given_stands_in_the_new_stage(cell):
    after = begin_stage(full_state(cell), STAGES[2], remarks=("moved",), message="said")
    assert (after.remarks, after.message, after.fault) == (("moved",), "said", "")
