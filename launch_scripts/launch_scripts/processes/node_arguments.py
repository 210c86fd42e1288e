"""Parsed options as the command line of a node process."""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterable

from setcmas_ctrl.communication.options import CommunicationOptions
from setcmas_ctrl.control.options import ControllerOptions, LawOptions


def node_arguments(args: argparse.Namespace, names: Iterable[str]) -> list[str]:
    """Return `--name value` for each named option that has a value.

    Lists repeat the option; flags stand alone.
    """
    arguments = []
    for name in names:
        value = getattr(args, name)
        option = f'--{name.replace("_", "-")}'
        for item in value if isinstance(value, list) else [value]:
            if item is True:
                arguments.append(option)
            elif item is not None and item is not False and item != math.inf:
                arguments += [option, str(item)]
    return arguments


def law_arguments(args: argparse.Namespace, options: ControllerOptions) -> list[str]:
    """Return the command line of a controller process.

    Args:
        args: Parsed options that choose the control law and the communication.
        options: What the process is told besides.
    """
    chosen = (LawOptions.of(args), CommunicationOptions.of(args), options)
    return [argument for group in chosen for argument in group.arguments()]
