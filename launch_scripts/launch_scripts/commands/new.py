"""Write a control script, a robot or a lab file into the current folder, to begin with.

Examples:
  setcmas new my_law                               a commented law that runs
  setcmas new my_law --from consensus              a copy of a built-in law
  setcmas new my_law --from consensus --exercise   the exercise, with its maths left to fill in
  setcmas new my_robot --robot                     a robot of your own, for --model my_robot.py
  setcmas new --lab                                lab.yaml, a commented lab file for setcmas expe
"""

from __future__ import annotations

import argparse
import keyword
import re
import sys
from importlib import resources
from importlib.util import find_spec
from pathlib import Path

from launch_scripts.processes.environment import missing_ros
from setcmas_ctrl.scripts.loader import ALGORITHMS, EXERCISES, find_script
from setcmas_expe.lab.lab_file import DEFAULT_FILE
from setcmas_simu.errors import SetcmasError

CONTROL_LAW, ROBOT = 'control_law', 'robot'
"""The templates."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    parser.add_argument(
        'name', metavar='NAME', nargs='?', help='name of the script, such as my_law'
    )
    parser.add_argument(
        '--from',
        dest='source',
        metavar='LAW',
        help='copy this control law: a name that --algo accepts, or a path',
    )
    parser.add_argument(
        '--exercise',
        action='store_true',
        help='copy the exercise of that name (without --from: of the same name)',
    )
    parser.add_argument('--robot', action='store_true', help='a robot script, for --model')
    parser.add_argument(
        '--lab', action='store_true', help='a lab file with every default (default NAME: lab)'
    )


def main(args: argparse.Namespace) -> int:
    """Write the file and say what to do next; returns the exit status."""
    if args.lab:
        return write_lab_file(args)
    if not args.name:
        raise SetcmasError('no NAME was given; it must be the name of a script, such as my_law')
    target = new_file(args.name)
    if args.robot and (args.source or args.exercise):
        raise SetcmasError('--robot writes a robot script; --from and --exercise are for laws')
    if args.exercise:
        source = EXERCISES.file(args.source or target.stem)
    elif args.source:
        source = find_script(args.source)
    else:
        name = ROBOT if args.robot else CONTROL_LAW
        source = Path(str(resources.files('setcmas_ctrl') / 'templates' / f'{name}.py'))
    write(target, source.read_bytes())
    if not (args.source or args.exercise or args.robot) and target.stem in ALGORITHMS:
        print(
            f'--algo {target.stem} means this file now, and not the built-in law; to begin with a '
            f'copy of that: delete it, then setcmas new {target.stem} --from {target.stem}'
        )
    print(f'{target} is yours to edit; then')
    print(f'    {next_command(target.stem, source.stem)}')
    if args.exercise:
        print(f'    setcmas check {target.stem}')
    return 0


def write_lab_file(args: argparse.Namespace) -> int:
    """Write a copy of the default lab file and say what to do next; returns the exit status."""
    if args.source or args.exercise:
        raise SetcmasError('--lab writes a lab file; --from and --exercise are for scripts')
    target = Path(args.name or 'lab').with_suffix('.yaml')
    write(target, DEFAULT_FILE.read_bytes())
    print(f'{target} is yours to edit; then')
    print(f'    setcmas expe --emulate --lab {target} --algo nav_wp')
    return 0


def new_file(name: str) -> Path:
    """Return the script's file in the current folder, which does not exist yet.

    Raises:
        SetcmasError: The name is none that Python can import, or that of a module.
    """
    stem = name.removesuffix('.py')
    if not stem.isidentifier() or keyword.iskeyword(stem):
        near = re.sub(r'\W|^(?=\d)', '_', stem)
        raise SetcmasError(
            f"'{name}' cannot be the name of a script; it must be letters, digits and _, "
            f'such as {near if near.isidentifier() and not keyword.iskeyword(near) else "my_law"}'
        )
    if _is_module(stem):
        raise SetcmasError(
            f"'{stem}' is a module of Python or of a package, which the script would hide; choose "
            f'another name, such as my_{stem}'
        )
    return Path(f'{stem}.py')


def _is_module(stem: str) -> bool:
    """Return whether Python finds a module of that name, but for a script in this folder."""
    spec = find_spec(stem)
    own = str(Path(f'{stem}.py').resolve())
    return stem in sys.stdlib_module_names or (spec is not None and spec.origin != own)


def write(target: Path, content: bytes) -> None:
    """Write a file that must not exist yet.

    Raises:
        SetcmasError: It exists, or cannot be written.
    """
    try:
        with target.open('xb') as file:
            file.write(content)
    except FileExistsError:
        raise SetcmasError(f"'{target}' exists already and is kept; choose another name") from None
    except OSError as error:
        raise SetcmasError(f"'{target}' cannot be written: {error.strerror}") from error


def next_command(stem: str, source: str) -> str:
    """Return the command that tries a script written from a source, on this machine."""
    verb = 'offline' if missing_ros() else 'run'
    if source == 'ctc':
        return f'setcmas {verb} --algo consensus --nb-robots 8 --event-triggered --ctc {stem}'
    if source == ROBOT:
        return f'setcmas {verb} --algo consensus --nb-robots 5 --model {stem}.py'
    return f'setcmas {verb} --algo {stem} --nb-robots 5'
