"""The tab that shows the robot link."""
