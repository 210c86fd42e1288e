"""Errors that users can correct, such as a missing package, and what was probably meant."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager


class SetcmasError(Exception):
    """Wrong user input: the message has the value, what it must be, and what to do next.

    Commands print the message on one line and exit with status 2.
    """


_IN_A_WORKSPACE = (
    'PIP_BREAK_SYSTEM_PACKAGES=1 rosdep install --from-paths src --ignore-src -y '
    '(docs/ros.md lists what rosdep does not know)'
)


def install_command(extra: str) -> str:
    """Return the command that installs the packages of an extra, such as 'study'.

    In a workspace built by colcon, rosdep installs them.
    """
    from importlib import metadata  # takes 2 MB, and few processes need it

    try:
        metadata.distribution('setcmas')
    except metadata.PackageNotFoundError:
        return _IN_A_WORKSPACE
    return f"pip install 'setcmas[{extra}]'"


@contextmanager
def needs(extra: str) -> Iterator[None]:
    """Import packages of an extra; raise SetcmasError with its pip command if one is missing."""
    try:
        yield
    except ModuleNotFoundError as error:
        if sys.platform == 'emscripten':
            raise SetcmasError(
                f"'{extra}' needs {error.name}, which web pages do not have; use setcmas on your "
                f'computer: {install_command(extra)}'
            ) from error
        missing = f'{error.name} is needed and is missing'
        raise SetcmasError(f'{missing}; this installs it: {install_command(extra)}') from error


@contextmanager
def file_errors(what: str) -> Iterator[None]:
    """Raise SetcmasError for an OSError inside; `what` is such as "'a.csv' cannot be read"."""
    try:
        yield
    except BrokenPipeError:  # the reader of the output is gone; the command ends quietly
        raise
    except OSError as error:
        raise SetcmasError(f'{what}: {error.strerror}') from error


def nearest(name: object, known: Iterable[str], most: int = 1) -> list[str]:
    """Return the known names that are most like a name, whatever their case."""
    import difflib  # a page in a browser starts sooner without it

    by_case = {one.lower(): one for one in known}
    return [by_case[one] for one in difflib.get_close_matches(str(name).lower(), by_case, n=most)]


def did_you_mean(name: object, known: Iterable[str], most: int = 1) -> str:
    """Return '; did you mean ...?' with the most similar names; empty if none is similar."""
    near = nearest(name, known, most)
    return f'; did you mean {" or ".join(near)}?' if near else ''


def it_must_be(accepted: str, name: object, known: Iterable[str]) -> str:
    """Return '; it must be ...', after the most similar of the known names if one is similar."""
    hint = did_you_mean(name, known)
    return f'{hint} It must be {accepted}' if hint else f'; it must be {accepted}'
