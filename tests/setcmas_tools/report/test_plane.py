import numpy as np
from report_pages import unpacked

from setcmas_tools.offline.engine import simulate
from setcmas_tools.replay.history import RunHistory
from setcmas_tools.report.plane import plane_entry


def test_drawings_and_links_are_those_of_the_run(failed_run):
    entry = plane_entry(RunHistory(failed_run))

    assert [drawn['marker'] for drawn in entry['drawings']] == [True] * 3
    own = entry['drawings'][0]
    assert np.allclose(unpacked(own['x']), unpacked(own['t']))  # as the script draws it
    assert [look[1] for _, look in own['looks']] == ['#ff0000']
    assert entry['links'] == failed_run.record.changes.tolist()
    assert entry['sent'] == {}


def test_references_arena_and_obstacles_are_there():
    run = simulate('nav_wp', 1, 2.0, arena=(-6, 6, -6, 6), obstacles='disc 3 3 0.5')
    entry = plane_entry(RunHistory(run))
    marked, joined = entry['references']

    assert marked['points'] == joined['points'] == [list(p) for p in run.references.values['WPL']]
    assert (marked['marked'], joined['joined']) == (True, True)
    assert entry['arena'] == (-6, 6, -6, 6)
    assert entry['discs'] == ((3, 3, 0.5),)


def test_broadcasts_by_event_are_told():
    run = simulate('consensus', 3, 5.0, event_triggered=True)
    entry = plane_entry(RunHistory(run))

    for robot, times in run.record.trigger_times.items():
        assert np.allclose(unpacked(entry['sent'][robot]), times)
