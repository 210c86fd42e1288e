"""Bundle of a format: the zip that a teacher uploads to a platform, which then grades itself."""

from __future__ import annotations

from setcmas_simu.errors import SetcmasError
from setcmas_tools.grade_formats.bundles.archive import archive
from setcmas_tools.grade_formats.bundles.kit import Kit, rubric_files
from setcmas_tools.grade_formats.bundles.wheel import own_wheel, package_folders
from setcmas_tools.grade_formats.format import GRADE_FORMATS
from setcmas_tools.grading.rubric import Rubric


def make_bundle(name: str, rubric: Rubric, options: str = '') -> bytes:
    """Return the zip archive with which a platform grades by a rubric.

    Args:
        name: Of the format.
        rubric: The rubric.
        options: Further options of `setcmas grade` there.

    Raises:
        SetcmasError: There is no such format, it has no bundle, or a file of the rubric is
            somewhere else.
    """
    bundle = GRADE_FORMATS.get(name).bundle
    if bundle is None:
        known = ', '.join(
            known for known in GRADE_FORMATS.offers() if GRADE_FORMATS.get(known).bundle
        )
        raise SetcmasError(f"format '{name}' has no bundle; --make must be one of {known}")
    wheel, content = own_wheel()
    files = rubric_files(rubric.file, rubric.files, package_folders().values())
    path = f'rubric/{rubric.file.name}'
    kit = Kit(rubric.title, wheel, {wheel: content, **files}, path, options)
    return archive(bundle(kit))
