"""Made from a cell: the cell by a recipe; points that arms carry, and their speeds."""
