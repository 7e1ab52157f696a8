"""The tab that empties piles in simulation, and shows how."""
