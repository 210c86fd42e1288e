"""Size and structure of the product code of a checkout, to compare before with after.

python benchmarks/structure.py [CHECKOUT ...]

A room is a folder of a package, or a module outside these folders.
"""

from __future__ import annotations

import argparse
import ast
import statistics
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from quick_option import parsed
from tabulate import tabulate

PACKAGES = ('setcmas_simu', 'setcmas_ctrl', 'setcmas_expe', 'setcmas_tools', 'launch_scripts')
HERE = Path(__file__).parents[1]
FREE = ('simulate',)  # the one function that may have as many parameters as it has options


@dataclass
class Module:
    """A product module: where it is, its text, and its syntax tree."""

    path: Path
    name: str

    def __post_init__(self) -> None:
        self.text = self.path.read_text(encoding='utf-8')
        self.tree = ast.parse(self.text)

    @property
    def package(self) -> str:
        return self.name.split('.')[0]

    @property
    def room(self) -> str:
        return room(self.name)

    @property
    def lines(self) -> int:
        return self.text.count('\n')

    def functions(self) -> Iterator[ast.FunctionDef | ast.AsyncFunctionDef]:
        for node in ast.walk(self.tree):
            if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
                yield node

    def imports(self, names: Iterable[str]) -> set[str]:
        """Return those of some dotted names that are imported anywhere in the module."""
        found = set()
        for node in ast.walk(self.tree):
            if isinstance(node, ast.Import):
                found |= {alias.name for alias in node.names}
            elif isinstance(node, ast.ImportFrom):
                found |= {node.module, *(f'{node.module}.{alias.name}' for alias in node.names)}
        return found & set(names)


def room(name: str) -> str:
    """Return the room of a module."""
    return '.'.join(name.split('.')[:2])


def modules(checkout: Path) -> list[Module]:
    """Return the product modules of a checkout."""
    found = []
    for package in PACKAGES:
        for path in sorted((checkout / package / package).rglob('*.py')):
            parts = path.relative_to(checkout / package).with_suffix('').parts
            found.append(Module(path, '.'.join(parts).removesuffix('.__init__')))
    return found


def parameters(function: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    """Return how many parameters a function has, without self and cls."""
    arguments = function.args
    named = [*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs]
    return sum(argument.arg not in ('self', 'cls') for argument in named)


def imports_between_rooms(found: list[Module]) -> set[tuple[str, str]]:
    """Return the pairs of rooms of one package of which the first imports the second."""
    names = {module.name for module in found} - set(PACKAGES)
    return {
        (module.room, room(name))
        for module in found
        for name in module.imports(names)
        if room(name) != module.room and name.split('.')[0] == module.package
    }


def spread(values: list[int]) -> str:
    """Return median, 90th percentile and maximum."""
    p90 = statistics.quantiles(values, n=10, method='inclusive')[-1]
    return f'{statistics.median(values):.0f} / {p90:.0f} / {max(values)}'


def figures(checkout: Path) -> dict[str, str]:
    """Return what is measured of a checkout, by name."""
    found = modules(checkout)
    functions = [function for module in found for function in module.functions()]
    most = max((f for f in functions if f.name not in FREE), key=parameters)
    written = [module.lines for module in found if module.text.strip()]
    lengths = [(f.end_lineno or 0) - f.lineno + 1 for f in functions]
    rows = {
        'files': str(len(found)),
        'lines': f'{sum(module.lines for module in found):,}',
        'lines of a file (median / p90 / most)': spread(written),
        'functions': str(len(functions)),
        'lines of a function (median / p90 / most)': spread(lengths),
        'most parameters (simulate apart)': f'{parameters(most)} ({most.name})',
        'functions of more than 8 parameters': str(sum(parameters(f) > 8 for f in functions)),
    }
    between_rooms = imports_between_rooms(found)
    for package in PACKAGES:
        rooms = {module.room for module in found if module.name.startswith(f'{package}.')}
        between = sum(importer.startswith(f'{package}.') for importer, _ in between_rooms)
        rows[f'{package}: rooms, imports between them'] = f'{len(rooms)}, {between}'
    rows['imports between rooms'] = str(len(between_rooms))
    longest = sorted(found, key=lambda module: -module.lines)[:5]
    for place, module in enumerate(longest, start=1):
        rows[f'longest file {place}'] = f'{module.lines} {module.name}'
    rows['lines of tests'] = f'{test_lines(checkout):,}'
    return rows


def test_lines(checkout: Path) -> int:
    paths = (checkout / 'tests').rglob('*.py')
    return sum(path.read_bytes().count(b'\n') for path in paths)


def main() -> None:
    """Print a table with a column for each checkout."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('checkout', type=Path, nargs='*', default=[HERE], help='[this one]')
    checkouts = parsed(parser).checkout
    columns = [figures(checkout) for checkout in checkouts]
    rows = [(name, *(column[name] for column in columns)) for name in columns[0]]
    headers = ['', *(checkout.resolve().name for checkout in checkouts)]
    print(tabulate(rows, headers, tablefmt='github', disable_numparse=True))


if __name__ == '__main__':
    main()
