"""Cells whose controller answers at other ports."""

import dataclasses

from workbench.plugins.robot_link import controller_by


def at(cell, port, state_port):
    return dataclasses.replace(
        cell, controller=controller_by("abb-socket", port=port, state_port=state_port)
    )
