"""The values that pass from a scan to the robot: frozen data, numpy and SE3, nothing else."""
