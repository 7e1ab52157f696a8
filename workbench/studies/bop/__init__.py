"""Localization measured by BOP's metrics."""
