from setcmas_expe.safety.bridge_reports import StopReports


def test_each_stop_is_reported_once_and_so_is_its_end():
    warnings = []
    reports = StopReports(warnings.append)
    for step in range(20):
        reports.update({1: 'lost', 2: '', 3: 'lost'}, step / 20)
    for step in range(20, 60):
        reports.update({1: '', 2: '', 3: 'lost'}, step / 20)

    assert warnings == ['robots 1,3 stopped: lost', 'robot 1 free to move again']


def test_a_robot_at_the_edge_is_reported_once():
    warnings = []
    reports = StopReports(warnings.append)
    for step in range(100):
        reports.update({1: 'outside' if step % 4 else ''}, step / 20)

    assert warnings == ['robot 1 stopped: outside']


def test_another_reason_is_reported():
    warnings = []
    reports = StopReports(warnings.append)
    reports.update({1: 'outside'}, 0.0)
    reports.update({1: 'lost'}, 0.1)

    assert warnings == ['robot 1 stopped: outside', 'robot 1 stopped: lost']
