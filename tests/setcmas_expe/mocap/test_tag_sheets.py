"""Sheets as a printer would print them: sizes, numbers and directions of the tags, the board."""

import io

import numpy as np
import pytest

cv2 = pytest.importorskip('cv2')

from setcmas_expe.mocap.camera_poses import TagDetector  # noqa: E402
from setcmas_expe.mocap.tag_sheets import (  # noqa: E402
    BOARD,
    PAPERS,
    board,
    sheets,
)

DPI = 120
MM = 25.4 / DPI


def printed(figure):
    """Return a page as a printer prints it, grey."""
    content = io.BytesIO()
    figure.savefig(content, format='png', dpi=DPI)
    data = np.frombuffer(content.getvalue(), np.uint8)
    return cv2.imdecode(data, cv2.IMREAD_GRAYSCALE)


@pytest.mark.parametrize(('size', 'paper'), [(60.0, 'letter'), (152.0, 'a4')])
def test_tags_have_their_size_and_point_up(size, paper):
    found = {}
    for figure in list(sheets(2, 4, size, paper))[:-1]:
        picture = printed(figure)
        assert picture.shape == pytest.approx(np.array(PAPERS[paper][::-1]) / MM, abs=1)
        corners, twice = TagDetector().corners(picture)
        assert not twice
        found |= corners

    assert sorted(found) == [1, 2, 501, 502, 503, 504]
    for top_left, top_right, bottom_right, _ in found.values():
        assert (top_right - top_left) * MM == pytest.approx([size, 0], abs=0.2)
        assert (bottom_right - top_right) * MM == pytest.approx([0, size], abs=0.2)


@pytest.mark.parametrize('paper', PAPERS)
def test_the_board_is_found_whole(paper):
    *_, last = sheets(1, 4, 100.0, paper)
    picture = printed(last)

    corners, numbers, _, _ = cv2.aruco.CharucoDetector(board()).detectBoard(picture)

    assert len(numbers) == (BOARD[0] - 1) * (BOARD[1] - 1)
    across = np.ptp(corners.reshape(-1, 2)[:, 0]) * MM
    assert across == pytest.approx(1e3 * board().getSquareLength() * (BOARD[0] - 2), abs=0.3)
    dark = np.argwhere(picture < 128) * MM
    assert dark.min() > 9.0
    assert (dark.max(axis=0) < np.array(PAPERS[paper][::-1]) - 9.0).all()
