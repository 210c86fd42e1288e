import numpy as np
import pytest

from setcmas_simu.script_calls import Function
from setcmas_tools.grade.altered_solutions import altered_solutions, calls_of
from setcmas_tools.offline.offline_simulation import simulate
from setcmas_tools.run.scenario import Scenario


@pytest.mark.parametrize('solution', ['script', None])
def test_a_si_to_uni_is_asked_at_the_poses_and_velocities_of_a_submission(tmp_path, solution):
    script = tmp_path / 'half.py'
    script.write_text(
        'from setcmas_ctrl.si_to_uni import si_to_uni as built_in\n'
        'def si_to_uni(velocity, pose, komega):\n'
        '    V, omega = built_in(velocity, pose[2], komega)\n'
        '    return V / 2, omega\n'
    )
    base = Scenario.of('consensus', nb_robots=3, duration=4, komega=2.0)
    altered = altered_solutions(solution and script, [], Function.SI_TO_UNI, tmp_path)
    calls = calls_of('one', base, simulate(base, si_to_uni=script), Function.SI_TO_UNI, altered)

    assert calls.own.shape == (20, 3, 2)
    V, omega = calls.own[..., 0] / calls.solution[..., 0], calls.own[..., 1]
    np.testing.assert_allclose(V, 1.0 if solution else 0.5)
    np.testing.assert_allclose(omega, calls.solution[..., 1], atol=1e-12)
