"""Options of communication, the same for every command that runs control laws."""

from __future__ import annotations

import argparse
from typing import Any

from setcmas_ctrl.communication.graph import COMPLETE, PRESETS
from setcmas_ctrl.communication.settings import (
    Communication,
    communication,
    find_condition,
    graph_description,
)
from setcmas_ctrl.communication.triggering import CTC
from setcmas_ctrl.scripts.loader import compile_script
from setcmas_simu.options import not_negative, positive, probability

OPTIONS = ('event_triggered', 'ctc', 'graph', 'range', 'delay', 'loss', 'noise')
"""Names of the options; without any of them all robots know the newest pose of each other."""


def add_communication_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options that say who hears whom, when, and how badly."""
    group = parser.add_argument_group('communication (default: all robots hear each other)')
    group.add_argument(
        '--event-triggered',
        action='store_true',
        help='robots send their state only when a condition triggers',
    )
    group.add_argument(
        '--ctc',
        metavar='FILE',
        help='script with the condition ctc(pos, last_pos, t), found as --algo is (default: '
        'more than 0.25 m away from the position sent last)',
    )
    group.add_argument(
        '--graph',
        default=COMPLETE,
        metavar='NAME|FILE.yaml',
        help=f'who hears whom: {", ".join(PRESETS)}, or a file (default: %(default)s)',
    )
    group.add_argument(
        '--range', type=positive, metavar='M', help='robots hear each other up to this distance'
    )
    group.add_argument(
        '--delay',
        type=not_negative,
        default=0.0,
        metavar='S',
        help='messages arrive that much later (default: %(default)g s)',
    )
    group.add_argument(
        '--loss',
        type=probability,
        default=0.0,
        metavar='P',
        help='probability that a message is lost (default: %(default)g)',
    )
    group.add_argument(
        '--noise',
        type=not_negative,
        default=0.0,
        metavar='M',
        help='standard deviation of received positions (default: %(default)g m)',
    )


def chosen_communication(args: argparse.Namespace, nb_robots: int) -> Communication:
    """Return how a fleet communicates, as parsed options, --seed and --exercise want it.

    Raises:
        SetcmasError: The options contradict each other, or a file is missing or malformed.
    """
    return communication(nb_robots, **communication_values(args), seed=args.seed)


def communication_values(args: argparse.Namespace) -> dict[str, Any]:
    """Return the values of parsed options by name, with the script that --ctc means.

    Raises:
        SetcmasError: There is no such script.
    """
    values = {name: getattr(args, name) for name in OPTIONS}
    if args.ctc is not None:
        values['ctc'] = find_condition(args.ctc, args.exercise)
    return values


def check_communication(args: argparse.Namespace, nb_robots: int | None) -> None:
    """See that parsed options can be followed, before anything starts.

    Args:
        args: The options.
        nb_robots: Size of the fleet, if it is known already.

    Raises:
        SetcmasError: They cannot.
    """
    if args.ctc is not None:
        compile_script(find_condition(args.ctc, args.exercise), expected=CTC)
    graph_description(args.graph)
    if nb_robots is not None:
        chosen_communication(args, nb_robots)
