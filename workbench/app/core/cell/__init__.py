"""The cell by subject: its changes, its parts' grasps, new parts and tools, simulated piles."""
