"""Scripts and instructions of bundles, from templates beside the formats."""

from __future__ import annotations

from setcmas_tools.grade_formats.bundles.kit import Kit

_ENDING = '.jinja'


def filled_in(format_: str, kit: Kit) -> dict[str, str]:
    """Return the files of a format's folder of templates by path, filled in for a kit."""
    # Imported late: formats are listed without their bundles.
    from jinja2 import Environment, PackageLoader, StrictUndefined

    loader = PackageLoader('setcmas_tools.grade_formats')
    # No autoescape: these are scripts, and all that is filled in is the teacher's.
    templates = Environment(loader=loader, undefined=StrictUndefined, keep_trailing_newline=True)
    paths = templates.list_templates(filter_func=lambda path: path.startswith(f'{format_}/'))
    return {
        path.removeprefix(f'{format_}/').removesuffix(_ENDING): (
            templates.get_template(path).render(kit=kit)
        )
        for path in paths
    }
