"""Robots and worlds of Klamp't.

`bench planners --against klampt` needs Klamp't itself, of the extra `bench`.
"""
