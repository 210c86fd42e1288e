"""The option that chooses the formats of plots."""

from __future__ import annotations

import argparse

from setcmas_tools.plot_formats import FORMATS


def add_format_argument(parser: argparse.ArgumentParser) -> None:
    """Add --format."""
    parser.add_argument(
        '--format',
        nargs='+',
        choices=FORMATS,
        default=['png'],
        help='formats of the plots (default: png)',
    )
