"""Poses on pendants, and in files of hand-eye calibrations.

Imports `files`.
"""
