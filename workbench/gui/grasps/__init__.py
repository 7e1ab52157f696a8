"""The tab in which grasps are put on the part."""
