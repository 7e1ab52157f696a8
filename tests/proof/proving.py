"""The two proofs, asked alike: the plan is taken at its word for what is in the bin."""

from workbench.planning.proving.prove import prove as first
from workbench.proof.prove import prove as second


def by_first(cell, plan, **more):
    """The proof that is made after each planning."""
    return first(cell, plan, **more)


def by_second(cell, plan, **more):
    """The second opinion."""
    return second(cell, plan.scene, plan, **more)
