"""Parsed options as the command line of a node process."""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterable


def node_arguments(args: argparse.Namespace, names: Iterable[str]) -> list[str]:
    """Return `--name value` for each named option that has a value; lists repeat the option."""
    arguments = []
    for name in names:
        value = getattr(args, name)
        for item in value if isinstance(value, list) else [value]:
            if item is not None and item != math.inf:
                arguments += [f'--{name.replace("_", "-")}', str(item)]
    return arguments
