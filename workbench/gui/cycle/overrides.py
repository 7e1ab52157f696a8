"""The inputs for what one planning may want otherwise than the cell's policy."""

import viser

from workbench.app.core.value_checks import LARGEST_MARGIN, MOST_ITERATIONS
from workbench.gui.shared.visitor import whole
from workbench.model.cell import ORDER_NAMES, PlanOverrides, Policy
from workbench.plugins.planner import planner_names


class OverridesInputs:
    """Planner, iterations, order, margin and metric; as the cell has them to begin with."""

    def __init__(self, gui: viser.GuiApi, policy: Policy):
        """Add the controls."""
        self._planner = gui.add_dropdown(
            "Planner",
            # One that is not installed here stays visible: a plan is then refused with its name.
            tuple(dict.fromkeys((*planner_names(), policy.planner))),
            initial_value=policy.planner,
            hint="Searches the free legs; birrt is another name for rrtconnect. Those that improve "
            "what they found (prmstar, bitstar, informed-rrtstar, aorrtc) use all iterations.",
        )
        self._iterations = gui.add_number(
            "Iterations",
            policy.iterations,
            min=1,
            max=MOST_ITERATIONS,
            step=1,
            hint="That the planner may use for each free leg before it gives up.",
        )
        self._order = gui.add_dropdown(
            "First",
            ORDER_NAMES,
            initial_value=policy.order,
            hint="Which part is taken first: least time, highest, best score, nearest "
            "to the tool, farthest from the walls, or by the rules of the thesis.",
        )
        self._margin = gui.add_number(
            "Margin [mm]",
            round(policy.margin * 1000, 3),
            min=round(policy.margin * 1000, 3),
            max=LARGEST_MARGIN * 1000,
            step=0.5,
            hint="Kept to everything on free legs; never less than the cell demands.",
        )
        self._metric = gui.add_number(
            "Metric",
            policy.metric,
            min=0.05,
            max=1.0,
            step=0.05,
            hint="How much each joint counts of the one before it when planners measure; "
            "at 1 all joints count alike.",
        )

    def allow(self, *, is_allowed: bool) -> None:
        """Let the inputs be changed, or not."""
        fields = (self._planner, self._iterations, self._order, self._margin, self._metric)
        for field in fields:
            field.disabled = not is_allowed

    @property
    def overrides(self) -> PlanOverrides:
        """What is wanted now."""
        return PlanOverrides(
            self._planner.value,
            whole(self._iterations.value),
            self._order.value,
            self._margin.value / 1000,
            float(self._metric.value),
        )
