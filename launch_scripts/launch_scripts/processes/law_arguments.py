"""Command line of a controller process."""

from __future__ import annotations

import argparse

from setcmas_ctrl.communication.options import CommunicationOptions
from setcmas_ctrl.control.options import ControllerOptions, LawOptions
from setcmas_ctrl.filter.options import FilterOptions


def law_arguments(
    args: argparse.Namespace, options: ControllerOptions, safety: FilterOptions
) -> list[str]:
    """Return the command line of a controller process.

    Args:
        args: Parsed options that choose the control law and the communication.
        options: What the process is told besides.
        safety: What keeps robots apart.
    """
    chosen = (LawOptions.of(args), CommunicationOptions.of(args), safety, options)
    return [argument for group in chosen for argument in group.arguments()]
