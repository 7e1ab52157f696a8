"""The tab that shows what the cell is made of: to move things and jog the robot."""
