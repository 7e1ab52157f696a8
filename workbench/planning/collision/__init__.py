"""What is where, which pairs count, how near they come, and along which motions.

Imports `kinematics`.
"""
