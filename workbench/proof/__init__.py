"""The proof of a plan, by code that shares nothing with planning.

Imports `model` alone: its own kinematics (Pinocchio) and distances (Coal), its own table of which
pairs count, and its own bounds, so that an error of the planner is not an error here.
"""
