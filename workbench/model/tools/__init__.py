"""Tools that an arm puts down and takes up: where they stand, and the legs of a change."""
