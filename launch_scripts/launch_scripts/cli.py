"""The setcmas command: parser and dispatch.

Each command is in commands/, in a file named after it. Its options are declared there, and in the
files `*_options.py` of what it starts.
"""

# PYTHON_ARGCOMPLETE_OK
from __future__ import annotations

try:
    import argparse
    import importlib
    import os
    import sys
    from typing import Any, NoReturn

    from launch_scripts.environment import clean_environment
    from setcmas_simu import __version__
    from setcmas_simu.errors import SetcmasError, did_you_mean
except KeyboardInterrupt:  # Ctrl-C while modules are loaded
    raise SystemExit(130) from None

VERBS = {
    'run': 'simulate, control, record, convert and plot with one command',
    'offline': 'simulate and control without ROS, much faster than real time',
    'sweep': 'run offline many times with varied parameters, and collect the results in one table',
    'simu': 'simulate robots',
    'ctrl': 'run a control law on the robots',
    'view': 'show running robots or a finished run on a page in the browser',
    'expe': 'drive real robots under motion capture, or an emulated lab',
    'doctor': 'check this machine, and a lab before an experiment',
    'fault': 'inject a fault into an emulated lab',
    'record': 'record topics into a bag',
    'play': 'play a recording: poses, communication, drawings',
    'bag_to_csv': 'convert a bag to CSV files',
    'csv_to_plot': 'plot the CSV files of a run',
    'metrics': 'measure a run: path lengths, separation, settling times, task errors',
    'compare': 'compare runs: paths, distances, metrics, parameters, scripts',
    'identify': 'identify gain, lag and delay of robots from a run, for --model',
    'report': 'write a run as one page to hand in: replay, plots and script',
    'site': 'write a web page that runs laws in the browser',
    'list': 'list laws, robot models, mocap sources, metrics and plots',
    'check': 'check your law against its exercise',
    'grade': 'grade the submissions of a class, each in a sandbox',
    'camera': 'find robots by cameras and printed tags, in place of motion capture',
    'tags': 'write printable tags for robots and floor, which a camera finds',
    'new': 'write a starter control script, robot script or lab file',
}
"""The verbs and their purposes; each is a module in `commands`."""

_NO_VALUE = 'expected one argument'  # argparse's

_DESCRIPTION = """\
Simulation and experiments for teaching the control of multi-agent systems.

Write a control law as one Python function, run it on simulated robots, then on real ones.
Start with:

    setcmas run --algo consensus --nb-robots 8 --duration 40 --output out
"""


def _help_formatter(prog: str) -> argparse.HelpFormatter:
    return argparse.RawDescriptionHelpFormatter(prog, max_help_position=28)


class Parser(argparse.ArgumentParser):
    """A parser with one-line errors and unwrapped help texts."""

    def __init__(self, **kwargs: Any) -> None:
        """Create the parser; arguments as for ArgumentParser."""
        defaults: dict[str, Any] = {'formatter_class': _help_formatter, 'allow_abbrev': False}
        super().__init__(**(defaults | kwargs))

    def error(self, message: str) -> NoReturn:
        """Print one line and exit with status 2."""
        if message.endswith(_NO_VALUE):
            flag = message.removeprefix('argument ').partition(':')[0].split('/')[-1]
            message += f'; write a value that begins with - as {flag}=-...'
        self.exit(2, f'{self.prog}: {message} (see {self.prog} --help)\n')


def spelled(arguments: list[str]) -> list[str]:
    """Return arguments with - in option names and _ in the verb, however the user typed them."""
    result = []
    for place, argument in enumerate(arguments):
        if argument.startswith('--'):
            name, equals, value = argument.partition('=')
            argument = f'--{name[2:].replace("_", "-")}{equals}{value}'
        elif place == 0 and not argument.startswith('-'):
            argument = argument.replace('-', '_')
        result.append(argument)
    return result


def build_parser(wanted: str) -> Parser:
    """Return the parser; load only the options of the wanted verb."""
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


def _refuse(parser: argparse.ArgumentParser, argument: str) -> NoReturn:
    known = [option for action in parser._actions for option in action.option_strings]
    hint = did_you_mean(argument.partition('=')[0], known)
    parser.error(f"unknown argument '{argument}'{hint}")


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; return the exit status."""
    clean_environment()
    arguments = spelled(sys.argv[1:] if arguments is None else arguments)
    if arguments[:1] == ['help']:
        arguments = [*arguments[1:2], '--help']
    try:
        try:
            args = _parsed(arguments)
            return int(args.main(args))
        finally:
            print(end='', flush=True)  # else Python finds a closed pipe after the end
    except SetcmasError as error:
        print(f'{" ".join(["setcmas", *arguments[:1]])}: {error}', file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130
    except BrokenPipeError:  # as in `setcmas run ... | head`: the work is done
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0


def _parsed(arguments: list[str]) -> argparse.Namespace:
    """Parse the arguments; exit after a help text or a mistake."""
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
    if wanted and wanted not in VERBS:
        hint = did_you_mean(wanted, VERBS)
        parser.error(f"unknown verb '{wanted}'; must be one of {', '.join(VERBS)}{hint}")
    args, unknown = parser.parse_known_args(arguments)
    if unknown:
        _refuse(args.parser if args.verb else parser, unknown[0])
    if not args.verb:
        parser.print_help()
        parser.exit()
    return args


def bag_to_csv() -> int:
    """Run `bag_to_csv` as a separate command."""
    return main(['bag_to_csv', *sys.argv[1:]])


def csv_to_plot() -> int:
    """Run `csv_to_plot` as a separate command."""
    return main(['csv_to_plot', *sys.argv[1:]])


if __name__ == '__main__':
    sys.exit(main())
