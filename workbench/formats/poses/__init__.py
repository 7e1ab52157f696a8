"""Poses as other programs have them: on pendants, and in files of hand-eye calibrations.

Imports `files`.
"""
