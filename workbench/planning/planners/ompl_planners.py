"""Planners of the Open Motion Planning Library, by the interface of our own.

The library's random numbers belong to the whole process, and it warns that a seed set anew comes
too late.  It does for samplers that exist; every planner made after it draws from the new seed, and
here nothing of a request outlives it: the same request gives the same path whatever ran before
(`tests/planning/planners/test_planners.py`).  No other file touches that generator.

PRM* is our own (`prm_star.py`): the library's looks for a solution in a second thread, so what it
finds depends on timing.

Source: I. A. Sucan, M. Moll and L. E. Kavraki, "The Open Motion Planning Library", IEEE Robotics
and Automation Magazine 19(4), 2012; for each planner the paper named at ompl.kavrakilab.org.
"""

from typing import Literal, cast

import numpy as np
from ompl import base, geometric, util

from workbench.model.geometry import Floats
from workbench.plugins.planner import EdgeCheck, Planner, Search

Name = Literal["BITstar", "LBKPIECE1", "InformedRRTstar", "AORRTC", "RRTConnect"]

LIMIT_SLACK = 1e-9
"""[rad] By how much a start on a joint limit may miss it after scaling by the metric's weights."""

util.setLogLevel(util.LogLevel.LOG_NONE)


class _Edges(base.MotionValidator):
    """Asks our edge check; `scale` (n,) takes the library's coordinates back to radians."""

    def __init__(self, space: base.SpaceInformation, is_clear: EdgeCheck, scale: Floats) -> None:
        super().__init__(space)
        self._is_clear = is_clear
        self._scale = scale

    def checkMotion(self, a: base.State, b: base.State, *rest: object) -> bool:
        return bool(self._is_clear(_values(a, self._scale), _values(b, self._scale)))


class _States(base.StateValidityChecker):
    """A state is a motion that goes nowhere."""

    def __init__(self, space: base.SpaceInformation, edges: _Edges) -> None:
        super().__init__(space)
        self._edges = edges

    def isValid(self, state: base.State) -> bool:
        return self._edges.checkMotion(state, state)


def ompl_planner(name: Name) -> Planner:
    """OMPL's planner of that name; it searches until its iterations are used up.

    Those that improve what they found use all of them.  The metric's weights become the
    space's scale.
    """

    def search(
        start: Floats,
        goal: Floats,
        lower: Floats,
        upper: Floats,
        weights: Floats,
        is_clear: EdgeCheck,
        *,
        iterations: int,
        rng: np.random.Generator,
    ) -> Search:
        if is_clear(start, goal):
            return Search(np.array([start, goal]), 0)
        util.RNG.setSeed(int(rng.integers(1, 2**31)))
        scale = 1.0 / weights
        space = _space(lower * weights - LIMIT_SLACK, upper * weights + LIMIT_SLACK)
        information = base.SpaceInformation(space)

        edges = _Edges(information, is_clear, scale)
        states = _States(information, edges)
        information.setStateValidityChecker(states)
        information.setMotionValidator(edges)
        information.setup()
        problem = base.ProblemDefinition(information)
        problem.setStartAndGoalStates(_state(space, start * weights), _state(space, goal * weights))
        problem.setOptimizationObjective(base.PathLengthOptimizationObjective(information))
        planner: base.Planner = getattr(geometric, name)(information)
        planner.setProblemDefinition(problem)
        planner.setup()
        asked = 0

        def is_over() -> bool:
            nonlocal asked
            asked += 1
            return asked > iterations

        planner.solve(base.PlannerTerminationCondition(is_over))
        used = min(asked, iterations)
        if not problem.hasExactSolution():
            return Search(None, used)
        found = cast(geometric.PathGeometric, problem.getSolutionPath()).getStates()
        inner = [_values(state, scale) for state in found[1:-1]]
        return Search(np.array([start, *inner, goal]), used)

    return search


def _space(lower: Floats, upper: Floats) -> base.RealVectorStateSpace:
    bounds = base.RealVectorBounds(len(lower))
    for k, (low, high) in enumerate(zip(lower.tolist(), upper.tolist(), strict=True)):
        bounds.setLow(k, low)
        bounds.setHigh(k, high)
    space = base.RealVectorStateSpace(len(lower))
    space.setBounds(bounds)
    return space


def _state(space: base.RealVectorStateSpace, values: Floats) -> base.State:
    state = space.allocState()
    cast(base.RealVectorStateType, state)[0 : len(values)] = values.tolist()
    return state


def _values(state: base.State, scale: Floats) -> Floats:
    return np.array(cast(base.RealVectorStateType, state)[0 : len(scale)]) * scale


BIT_STAR = ompl_planner("BITstar")
LBKPIECE = ompl_planner("LBKPIECE1")
INFORMED_RRT_STAR = ompl_planner("InformedRRTstar")
AORRTC = ompl_planner("AORRTC")
RRT_CONNECT = ompl_planner("RRTConnect")
"""For comparison only: `rrtconnect` is our own."""
