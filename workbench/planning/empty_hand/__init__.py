"""Paths of a hand that takes no part: a scanner to its view, stirring, a change of tool."""
