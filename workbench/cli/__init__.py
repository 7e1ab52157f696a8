"""The commands that can be typed, and the only place that wires everything together.

Each command imports what it needs when it runs, so that `workbench --help` is there at once.
"""
