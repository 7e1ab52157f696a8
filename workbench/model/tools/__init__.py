"""Tools that an arm puts down and takes up, with the legs of a change; what a hand may hold."""
