import pytest
from processes import refuses, run_here

pytest.importorskip('cv2')


def test_the_sheets_are_written(tmp_path):
    result = run_here('tags', '--nb-robots', '2', '--size', '60', cwd=tmp_path)

    assert result.returncode == 0, result.stderr
    assert result.stdout.startswith('tags.pdf: 7 pages')
    assert (tmp_path / 'tags.pdf').read_bytes().startswith(b'%PDF')


@pytest.mark.parametrize(
    ('arguments', 'message'),
    [
        (('--nb-robots', '0'), '--nb-robots is 0; it must be a whole number from 1 to 500'),
        (('--size', '300'), '--size is 300; it must be from 20 to 152 mm'),
        (('--paper', 'a5'), "--paper is 'a5'; it must be a4 or letter"),
        (('--floor-tags', '3'), '--floor-tags is 3; it must be a whole number from 4 to 20'),
        (('-o', 'tags.png'), "--output is 'tags.png'; it must end in .pdf"),
        (('-o', 'no/tags.pdf'), "'no/tags.pdf' cannot be written: No such file"),
        (('-o', 'there.pdf'), "'there.pdf' already exists"),
    ],
)
def test_invalid_options_are_refused(tmp_path, arguments, message):
    (tmp_path / 'there.pdf').touch()

    refuses('tags', '--nb-robots', '3', *arguments, message=message, cwd=tmp_path)
