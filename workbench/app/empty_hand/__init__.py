"""Motions of an empty hand, planned and proven: a path to a view, stirring, a change of tool."""
