"""A part's library of grasps, made by trying what a tool can hold in simulated piles of the part.

May import model, formats, perception, planning and its neighbours in app.
"""
