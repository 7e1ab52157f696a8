"""Paths of a hand that takes no part: of a scanner to its view, and through parts to stir them."""
