"""A page from a template: everything from a run or a student is escaped, nothing is fetched."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from jinja2 import ChoiceLoader, Environment, PackageLoader, StrictUndefined

_CONTROL = re.compile(r'[\x00-\x08\x0b-\x1f\x7f-\x9f]')


def templates(package: str) -> Environment:
    """Return the templates of a package, and those that all pages share.

    Args:
        package: Such as 'setcmas_tools.report', with a folder `templates`.
    """
    return Environment(
        loader=ChoiceLoader([PackageLoader(package), PackageLoader(__package__)]),
        autoescape=True,  # names, messages and scripts are anybody's
        undefined=StrictUndefined,
    )


def rendered(found: Environment, template: str, **known: Any) -> str:
    """Return a page from one of these templates, without control characters."""
    text = found.get_template(template).render(**known)
    return _CONTROL.sub('\N{REPLACEMENT CHARACTER}', text)


def write_page(path: Path, text: str) -> None:
    """Write a page.

    Raises:
        OSError: It cannot be written.
    """
    path.write_text(text, encoding='utf-8', errors='replace', newline='\n')
