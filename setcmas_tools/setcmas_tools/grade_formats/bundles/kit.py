"""Kit that a platform grades with: setcmas as a wheel, and a rubric with its files."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

from setcmas_simu.errors import SetcmasError


@dataclass(frozen=True)
class Kit:
    """What every bundle holds.

    Attributes:
        title: That of the rubric.
        wheel: Name of the wheel of setcmas.
        files: Contents by path: the wheel, and the rubric with its files under `rubric/`.
        rubric: Path of the rubric among them.
        options: Further options of `setcmas grade`, such as '--trust'; may be empty.
    """

    title: str
    wheel: str
    files: Mapping[str, bytes]
    rubric: str
    options: str = ''

    def filled_in(self, format_: str) -> dict[str, str]:
        """Return the scripts and instructions of a format by path, from its templates."""
        # Imported late: formats are listed without their bundles.
        from jinja2 import Environment, PackageLoader, StrictUndefined

        # No autoescape: these are scripts, and all that is filled in is the teacher's.
        templates = Environment(
            loader=PackageLoader('setcmas_tools.grade_formats'),
            undefined=StrictUndefined,
            keep_trailing_newline=True,
        )
        paths = templates.list_templates(filter_func=lambda path: path.startswith(f'{format_}/'))
        return {
            path.removeprefix(f'{format_}/').removesuffix('.jinja'): (
                templates.get_template(path).render(kit=self)
            )
            for path in paths
        }


def rubric_files(
    rubric: Path, files: Iterable[Path], packages: Iterable[Path]
) -> dict[str, bytes]:
    """Return the files that a rubric consists of by their paths in a bundle.

    Args:
        rubric: The rubric.
        files: All its files, itself among them.
        packages: Folders whose files come with setcmas.

    Raises:
        SetcmasError: One is neither in the rubric's folder nor part of setcmas.
    """
    folder = rubric.resolve().parent
    shipped = [package.resolve() for package in packages]
    found = {f'rubric/{rubric.name}': rubric.read_bytes()}
    for path in (file.resolve() for file in files):
        if path.is_relative_to(folder):
            found[f'rubric/{path.relative_to(folder).as_posix()}'] = path.read_bytes()
        elif not any(path.is_relative_to(package) for package in shipped):
            raise SetcmasError(
                f"'{path}' must be in the folder of the rubric, or below; copy it there, and "
                f"change its place in '{rubric}'"
            )
    return found
