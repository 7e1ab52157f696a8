"""Motions of an empty hand, planned and proven: a scanner's path to its view, stirring."""
