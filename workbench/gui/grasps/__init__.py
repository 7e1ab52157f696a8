"""Tab Grasps."""
