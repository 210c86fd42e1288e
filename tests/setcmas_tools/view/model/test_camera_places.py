import numpy as np
import pytest

from setcmas_tools.view.model.camera_places import FOV, VIEWS, place


@pytest.mark.parametrize('covered', [0.0, 0.3, 0.49])
@pytest.mark.parametrize('aspect', [0.6, 1.0, 1.8])
@pytest.mark.parametrize('view', VIEWS)
def test_the_whole_ground_is_seen_beside_the_panel(view, aspect, covered):
    camera, target = place(view, 7.5, aspect, covered)

    ahead = (target - camera) / np.linalg.norm(target - camera)
    right = np.cross(ahead, [0, 0, 1])
    right /= np.linalg.norm(right)
    corners = 7.5 * np.array([[x, y, 0] for x in (-1, 1) for y in (-1, 1)]) - camera
    depth = corners @ ahead
    u = corners @ right / depth / np.tan(FOV / 2) / aspect  # -1 left, 1 right
    v = corners @ np.cross(right, ahead) / depth / np.tan(FOV / 2)

    assert u.min() >= -1.0 - 1e-3
    assert u.max() <= 1.0 - 2 * covered + 1e-3
    assert abs(v).max() <= 1.0 + 1e-3
    # It fills the height, or the width that is free.
    filled = (np.ptp(v) / 2, np.ptp(u) / 2 / (1 - covered))
    assert max(filled) == pytest.approx(1.0, abs=0.15)
    assert target[2] == pytest.approx(0.0)
