"""Grasp libraries, tested in simulated piles.

May import model, formats, perception, planning and its neighbours in app.
"""
