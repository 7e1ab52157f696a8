"""Tab Cell: moving things, jogging the robot."""
