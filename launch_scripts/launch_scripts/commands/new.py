"""Write a script, a lab file or a practical session to the current folder.

Examples:
  setcmas new my_law                               a commented law that runs
  setcmas new my_law --from consensus              a copy of a built-in law
  setcmas new my_law --from consensus --exercise   the exercise, for you to fill in
  setcmas new my_robot --robot                     your own robot, for --model my_robot.py
  setcmas new my_driver --si-to-uni                how velocities become commands
  setcmas new --lab                                lab.yaml, a commented lab file for setcmas expe
  setcmas new --session 3                          session_3/: exercise, scenarios and questions
"""

from __future__ import annotations

import argparse
import keyword
import re
import sys
from importlib import resources
from importlib.util import find_spec
from pathlib import Path

from launch_scripts.environment import missing_ros
from setcmas_ctrl.laws.script_loader import ALGORITHMS, CONDITIONS, EXERCISES
from setcmas_ctrl.laws.script_search import find_script
from setcmas_expe.lab.lab_file import DEFAULT_FILE
from setcmas_simu.errors import SetcmasError, file_errors

SESSION_PAGE = 'session.md'


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    name = 'name of the script, such as my_law'
    parser.add_argument('name', metavar='NAME', nargs='?', help=name)
    source = 'copy this control law or triggering condition: a name, or a path'
    parser.add_argument('--from', dest='source', metavar='LAW', help=source)
    parser.add_argument(
        '--exercise',
        action='store_true',
        help='copy the exercise, with blanks to fill in, instead of the finished law; without '
        '--from, the exercise called NAME',
    )
    others = parser.add_mutually_exclusive_group()
    others.add_argument('--robot', action='store_true', help='a robot script, for --model')
    conversion = 'a script with the built-in si_to_uni, for --si-to-uni'
    others.add_argument('--si-to-uni', action='store_true', help=conversion)
    lab = 'a lab file with every default (default NAME: lab)'
    others.add_argument('--lab', action='store_true', help=lab)
    session = 'a folder for practical session N of three hours (default NAME: session_N)'
    others.add_argument('--session', metavar='N', help=session)


def main(args: argparse.Namespace) -> int:
    """Write the file and show the next step; return the exit status."""
    is_other = any((args.robot, args.si_to_uni, args.lab, args.session))
    if is_other and (args.source or args.exercise):
        raise SetcmasError('--from and --exercise are for laws; leave the other option out')
    if args.session:
        return _write_session(args)
    if args.lab:
        return _write_lab_file(args)
    if not args.name:
        raise SetcmasError('NAME is missing; give the script a name, such as my_law')
    target = _new_file(args.name)
    if args.exercise:
        source = EXERCISES.file(args.source or target.stem)
    elif args.source:
        is_condition = args.source in CONDITIONS
        source = CONDITIONS.file(args.source) if is_condition else find_script(args.source)
    else:
        name = 'robot' if args.robot else 'si_to_uni' if args.si_to_uni else 'control_law'
        source = Path(str(resources.files('setcmas_ctrl') / 'templates' / f'{name}.py'))
    _write(target, source.read_bytes())
    if not (args.source or args.exercise or is_other) and target.stem in ALGORITHMS:
        print(
            f'--algo {target.stem} now runs this file instead of the built-in law; to copy that '
            f'law, delete this file and run setcmas new {target.stem} --from {target.stem}'
        )
    print(f'edit {target}, then run')
    print(f'    {_next_command(target.stem, source.stem)}')
    if args.exercise:
        print(f'    setcmas check {target.stem}')
    return 0


def _write_lab_file(args: argparse.Namespace) -> int:
    target = Path(args.name or 'lab').with_suffix('.yaml')
    _write(target, DEFAULT_FILE.read_bytes())
    print(f'edit {target}, then run')
    print(f'    setcmas expe --emulate --lab {target} --algo nav_wp')
    return 0


def _write_session(args: argparse.Namespace) -> int:
    sessions = Path(str(resources.files('setcmas_ctrl') / 'sessions'))
    source = sessions / f'session_{args.session}.md'
    if not source.is_file():
        known = sorted(path.stem.rpartition('_')[2] for path in sessions.glob('session_*.md'))
        raise SetcmasError(f"there is no session '{args.session}'; there are {', '.join(known)}")
    _, head, page = source.read_text(encoding='utf-8').split('---\n', 2)
    folder = Path(args.name or source.stem)
    _check_new(folder)
    with file_errors(f"'{folder}' cannot be created"):
        folder.mkdir()
    end = f'_{args.session}'
    files = [path for path in sessions.iterdir() if path.stem.endswith(end)]
    contents = {f'{one.stem.removesuffix(end)}{one.suffix}': one.read_bytes() for one in files}
    contents |= {SESSION_PAGE: page.encode(), 'questions.md': questions(page).encode()}
    for exercise in re.findall(r'exercise: (\w+)', head):
        contents[f'my_{exercise}.py'] = EXERCISES.file(exercise).read_bytes()
    for name, content in contents.items():
        _write(folder / name, content)
    print(f'read {folder / SESSION_PAGE}, and work in the folder:')
    print(f'    cd {folder}')
    return 0


def questions(page: str) -> str:
    """Return the title and the questions of a session's page, with room for answers."""
    title = page.strip().partition('\n')[0]
    asked = re.findall(r'^\*\*Q\d+\.\d+\*\*.*?(?=\n\n|\n*\Z)', page, re.DOTALL | re.MULTILINE)
    return '\n\n'.join([title, 'Names:', *(f'{one}\n\n' for one in asked)])


def _new_file(name: str) -> Path:
    """Return the path of a new script in the current folder, if Python can import the name."""
    stem = name.removesuffix('.py')
    if not stem.isidentifier() or keyword.iskeyword(stem):
        raise SetcmasError(
            f"'{name}' cannot be the name of a script; use letters, digits and _, such as my_law"
        )
    found = find_spec(stem)
    target = Path(f'{stem}.py')
    if stem in sys.stdlib_module_names or (found and found.origin != str(target.resolve())):
        raise SetcmasError(
            f"'{stem}' is a module of Python or of a package, which the script would hide; choose "
            f'another name, such as my_{stem}'
        )
    return target


def _check_new(path: Path) -> None:
    if path.exists():
        raise SetcmasError(f"'{path}' already exists; choose another name")


def _write(target: Path, content: bytes) -> None:
    _check_new(target)
    with file_errors(f"'{target}' cannot be written"):
        target.write_bytes(content)


def _next_command(stem: str, source: str) -> str:
    """Return a command to try the new script on this machine."""
    verb = 'offline' if missing_ros() else 'run'
    if source == 'ctc' or source in CONDITIONS:
        return f'setcmas {verb} --algo consensus --nb-robots 8 --event-triggered --ctc {stem}'
    if source in ('si_to_uni', 'point_ahead'):
        return f'setcmas {verb} --algo nav_wp --si-to-uni {stem}'
    if source == 'robot':
        return f'setcmas {verb} --algo consensus --nb-robots 5 --model {stem}.py'
    return f'setcmas {verb} --algo {stem} --nb-robots 5'
