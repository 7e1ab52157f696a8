"""Proofs of plans that are taken at their word for what is in the bin."""

from workbench.proof.prove import prove


def proof_of(cell, plan, **more):
    """The proof of a plan in the scene that it states."""
    return prove(cell, plan.scene, plan, **more)
