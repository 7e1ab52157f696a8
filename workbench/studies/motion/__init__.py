"""Studies of motion: problems from files, and both arms as one, beside other planners."""
