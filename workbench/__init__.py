"""Workbench: plan, prove, approve and run robotic bin picks from a web page."""

__version__ = "0.1.0"
