from setcmas_ctrl.rviz_marker import publish_marker
from setcmas_tools import simulate
from setcmas_tools.replay.history import RunHistory
from setcmas_tools.view.model.marker_store import MarkerStore
from setcmas_tools.view.replay.drawings import ReplayedDrawings


def test_what_stands_there():
    run = simulate(
        'traj_tracking', 1, 1.0, filter='barrier', arena=(-6, 6, -5, 5),
        obstacles='disc 3 2 0.5; polygon -2 -3 -1 -3 -1 -2',
    )  # fmt: skip
    store = MarkerStore()
    ReplayedDrawings(RunHistory(run), store)
    (disc,) = [shape.rows[0] for _, shape in store.of_kind('cylinder')]
    segments = [len(shape.rows) for _, shape in store.of_kind('lines')]

    assert disc[:2].tolist() == [3, 2]
    assert disc[7:9].tolist() == [1, 1]
    assert sorted(segments) == [3, 4, 180]  # the polygon, the arena, the reference's circle
    assert store.reach() == 6.0


def test_the_marks_of_a_task():
    store = MarkerStore()
    ReplayedDrawings(RunHistory(simulate('nav_wp', 1, 1.0)), store)

    assert len(store.solids('cylinder', {})) >= 3


def test_markers_move_and_trails_grow_and_shrink():
    def control(robot, nb_robots, poses, t):
        publish_marker(t, 0, 0, robot, color=[1, 0, 0], scale=0.3, alpha=0.5, marker_name='goal')
        return 0.1, 0.0

    store = MarkerStore()
    drawings = ReplayedDrawings(RunHistory(simulate(control, 2, 4.0)), store)
    seen = []
    for t in (1.05, 3.0, 2.0):
        drawings.show(t)
        seen.append(store.solids('sphere', {})[:, 0].tolist())

    assert seen == [[1.0, 1.0], [3.0, 3.0], [2.0, 2.0]]
    assert store.solids('sphere', {})[0, 7:].tolist() == [0.3, 0.3, 0.3, 1, 0, 0, 0.5]
