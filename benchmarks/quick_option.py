"""The option --quick of benchmarks: little of everything, to see that they work."""

from __future__ import annotations

import argparse
from typing import Any


def parsed(parser: argparse.ArgumentParser, **quick: Any) -> argparse.Namespace:
    """Return the arguments of a benchmark; with --quick, some have other values."""
    parser.add_argument('--quick', action='store_true', help='little of everything: a test of it')
    args = parser.parse_args()
    if args.quick:
        vars(args).update(quick)
    return args
