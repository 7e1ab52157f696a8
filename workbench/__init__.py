"""Workbench: plan, prove, approve and run robotic bin picks from a web page."""

from workbench.environment import prepare

__version__ = "0.1.0"

prepare()
