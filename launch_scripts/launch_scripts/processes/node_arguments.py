"""Parsed options as the command line of a node process."""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterable


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
