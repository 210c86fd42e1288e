"""The setcmas command: parser and dispatch."""

# PYTHON_ARGCOMPLETE_OK
from __future__ import annotations

import argparse
import difflib
import importlib
import os
import sys
from pathlib import Path
from typing import Any, NoReturn

from launch_scripts.processes.environment import leave_out_what_breaks
from launch_scripts.terminal.keyboard import kept_terminal
from setcmas_simu import __version__
from setcmas_simu.errors import SetcmasError

VERBS = {
    'run': 'simulate, control, record, convert and plot with one command',
    'offline': 'simulate and control without ROS, much faster than real time',
    'sweep': 'run offline many times, with parameters varied, into one table',
    'simu': 'simulate robots',
    'ctrl': 'run a control law on the robots',
    'view': 'show running robots or a finished run on a page in the browser',
    'expe': 'drive real robots under motion capture, or an emulated lab',
    'doctor': 'check this machine, and a lab before an experiment',
    'fault': 'let something go wrong in an emulated lab',
    'record': 'record all topics into a bag',
    'play': 'play a recording: topics as they were, but no commands',
    'bag_to_csv': 'convert a bag to CSV files',
    'csv_to_plot': 'plot the CSV files of a run',
    'metrics': 'measure a run: path, separation, settling time, errors of the task',
    'compare': 'compare runs: paths, distances, metrics, parameters, scripts',
    'identify': 'find gain, lag and delay of the robots in a run, for --model',
    'report': 'write a run as one page to hand in, with replay, plots and script',
    'list': 'list what has a name: laws, robot models, motion capture, metrics, plots',
    'check': 'check a law of your own against its exercise',
    'grade': 'grade the submissions of a class, each in a sandbox',
    'new': 'write a control script or a lab file to begin with',
}
"""The verbs and what each does; the module of the same name in `commands` does it."""

_NO_VALUE = 'expected one argument'  # argparse's

_DESCRIPTION = """\
Simulation and experiments for teaching the control of multi-agent systems.

Write the maths of a control law in one Python function, run it on simulated robots, then on
real ones. Start with:

    setcmas run --algo consensus --nb-robots 8 --duration 40 --output out
"""


def _help_formatter(prog: str) -> argparse.HelpFormatter:
    return argparse.RawDescriptionHelpFormatter(prog, max_help_position=28)


class Parser(argparse.ArgumentParser):
    """A parser whose errors are one line, and that shows help texts as they are written."""

    def __init__(self, **kwargs: Any) -> None:
        """Create the parser; arguments as for ArgumentParser."""
        defaults: dict[str, Any] = {
            'formatter_class': _help_formatter,
            'allow_abbrev': False,
        }
        super().__init__(**(defaults | kwargs))

    def error(self, message: str) -> NoReturn:
        """Print one line and exit with status 2."""
        if message.endswith(_NO_VALUE):
            flag = message.removeprefix('argument ').partition(':')[0].split('/')[-1]
            message += f'; one that begins with - is written {flag}=-...'
        self.exit(2, f'{self.prog}: {message} ({self.prog} --help tells more)\n')


def spelled(arguments: list[str]) -> list[str]:
    """Return arguments with - in option names and _ in the verb, however they were typed."""
    result = []
    for argument in arguments:
        if argument.startswith('--'):
            name, equals, value = argument.partition('=')
            argument = f'--{name[2:].replace("_", "-")}{equals}{value}'
        result.append(argument)
    for index, argument in enumerate(result):
        if not argument.startswith('-'):
            result[index] = argument.replace('-', '_') if index == 0 else argument
            break
    return result


def build_parser(wanted: str) -> Parser:
    """Return the parser; only the wanted verb's options are loaded."""
    parser = Parser(prog='setcmas', description=_DESCRIPTION)
    parser.add_argument('--version', action='version', version=f'setcmas {__version__}')
    verbs = parser.add_subparsers(dest='verb', metavar='VERB', title='verbs')
    for verb, purpose in VERBS.items():
        if verb == wanted:
            command = importlib.import_module(f'launch_scripts.commands.{verb}')
            description = command.__doc__ or ''
            subparser = verbs.add_parser(verb, help=purpose, description=description)
            command.add_arguments(subparser)
            subparser.set_defaults(main=command.main, parser=subparser)
        else:
            verbs.add_parser(verb, help=purpose)
    return parser


def _check_verb(parser: Parser, verb: str) -> None:
    if verb not in VERBS:
        near = difflib.get_close_matches(verb, VERBS, n=1)
        hint = f'; did you mean {near[0]}?' if near else ''
        parser.error(f"there is no verb '{verb}'; verbs are {', '.join(VERBS)}{hint}")


def _refuse(parser: argparse.ArgumentParser, argument: str) -> NoReturn:
    known = [option for action in parser._actions for option in action.option_strings]
    near = difflib.get_close_matches(argument.partition('=')[0], known, n=1)
    hint = f'; did you mean {near[0]}?' if near else ''
    parser.error(f"argument '{argument}' is not accepted{hint}")


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; returns the exit status."""
    leave_out_what_breaks()
    arguments = spelled(sys.argv[1:] if arguments is None else arguments)
    if arguments[:1] == ['help']:
        arguments = [*arguments[1:2], '--help']
    try:
        _check_current_folder()
        args = _parsed(arguments)
        with kept_terminal():
            return int(args.main(args))
    except SetcmasError as error:
        print(f'setcmas {arguments[0]}: {error}', file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130
    except BrokenPipeError:  # such as `setcmas run ... | head`: the work is done, nobody reads
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0


def _check_current_folder() -> None:
    try:
        Path.cwd()
    except FileNotFoundError as error:
        raise SetcmasError('the current folder was removed; change into another one') from error


def _parsed(arguments: list[str]) -> argparse.Namespace:
    """Return the parsed arguments; exits after a help text or a mistake."""
    completing = '_ARGCOMPLETE' in os.environ
    if completing:
        typed = os.environ.get('COMP_LINE', '').replace('-', '_').split()
        wanted = next((word for word in typed if word in VERBS), '')
    else:
        wanted = next((argument for argument in arguments if not argument.startswith('-')), '')
    parser = build_parser(wanted)
    if completing:
        import argcomplete

        argcomplete.autocomplete(parser)
    if wanted:
        _check_verb(parser, wanted)
    args, unknown = parser.parse_known_args(arguments)
    args.arguments = arguments[arguments.index(wanted) + 1 :] if wanted else []
    if unknown:
        _refuse(args.parser if args.verb else parser, unknown[0])
    if not args.verb:
        parser.print_help()
        parser.exit()
    return args


def bag_to_csv() -> int:
    """Run `bag_to_csv` as a command of its own."""
    return main(['bag_to_csv', *sys.argv[1:]])


def csv_to_plot() -> int:
    """Run `csv_to_plot` as a command of its own."""
    return main(['csv_to_plot', *sys.argv[1:]])


if __name__ == '__main__':
    sys.exit(main())
