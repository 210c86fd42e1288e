import math

import numpy as np
import pytest
import yaml
from ros1_recordings import CONSENSUS, needs_recordings

from launch_scripts.cli import main
from setcmas_simu.errors import SetcmasError
from setcmas_tools import simulate
from setcmas_tools.communication_record import Counts, record_of
from setcmas_tools.communication_record import write_csv as write_record
from setcmas_tools.fleet_table import fleet_table, write_csv
from setcmas_tools.metrics import compute, measure
from setcmas_tools.metrics_table import MOST_ROBOTS_IN_ROWS, table_lines
from setcmas_tools.metrics_yaml import as_dict, write_yaml
from setcmas_tools.task_references import References

MESSAGES = 'sender,receiver,sent,received,lost,mean_interval'
T = np.arange(0, 201) / 10  # 0 to 20 s at 10 Hz


def table(*robots):
    """A table of robots, each given as (times, x, y) or (times, x, y, v)."""
    rows = []
    for number, (t, x, y, *v) in enumerate(robots, start=1):
        columns = np.broadcast_arrays(t, number, x, y, 0.0, v[0] if v else 0.0, 0.0)
        rows += np.transpose(columns).tolist()
    return fleet_table(rows)


def numbers(value):
    if isinstance(value, dict):
        return [number for item in value.values() for number in numbers(item)]
    if isinstance(value, list):
        return [number for item in value for number in numbers(item)]
    return [value] if isinstance(value, float) else []


def write_run(folder, fleet, **parameters):
    (folder / 'csv').mkdir(parents=True)
    write_csv(fleet, folder / 'csv' / 'fleet.csv')
    (folder / 'run.yaml').write_text(yaml.safe_dump({'parameters': parameters}))
    return folder


def test_two_robots_in_consensus_settle_when_theory_says():
    # d(k+1) = (1 - K T) d(k) with K = 0.5 /s and T = 0.1 s is at most a share s of d(0) from
    # k = ln(s) / ln(1 - K T), rounded up: 0.95^59 = 0.0485 and 0.95^77 = 0.0193.
    distance = 4.0 * 0.95 ** np.arange(len(T))
    agreement = measure(table((T, 1 + distance / 2, 2), (T, 1 - distance / 2, 2))).consensus

    assert agreement.disagreement_at_start_m == pytest.approx(2.0)
    assert agreement.disagreement_at_end_m == pytest.approx(2.0 * 0.95**200)
    assert agreement.settling_time_5_percent_s == pytest.approx(5.9)
    assert agreement.settling_time_2_percent_s == pytest.approx(7.7)
    assert (agreement.final_centre_x_m, agreement.final_centre_y_m) == pytest.approx((1, 2))


def test_the_built_in_consensus_settles_when_theory_says():
    # Two robots that face each other: K = 0.5 /s, called each 0.2 s.
    run = simulate('consensus', 2, 12, poses=[[-0.9, 0.9], [0, 0], [0, math.pi]])
    agreement = measure(run.table).consensus

    theory = 0.2 * math.log(0.05) / math.log(1 - 0.5 * 0.2)
    assert agreement.settling_time_5_percent_s == pytest.approx(theory, abs=0.1)


def test_settling_is_for_good():
    values = np.where((T < 3) | ((T >= 8) & (T < 8.5)), 1.0, 0.01)
    again = measure(table((T, values, 0), (T, -values, 0))).consensus
    never = measure(table((T, 1.0, 0), (T, -1.0, 0))).consensus

    assert again.settling_time_5_percent_s == pytest.approx(8.5)
    assert never.settling_time_2_percent_s is None


def test_path_length_and_speed_of_a_circle():
    t = np.linspace(-1, 10 * math.pi, 400)
    motion = measure(table((t, 2 * np.cos(0.2 * t), 2 * np.sin(0.2 * t), 0.4))).robots[1]

    assert motion.path_length_m == pytest.approx(0.4 * t[t >= 0].max(), rel=5e-3)
    assert motion.mean_speed_m_s == pytest.approx(0.4, rel=1e-3)
    assert motion.largest_speed_m_s == pytest.approx(0.4)
    assert motion.end_x_m == pytest.approx(2.0)


def test_the_least_separation_with_its_time_and_robots():
    # Robot 1 passes robot 2 at 0.3 m, between two samples.
    near = measure(table((T, T - 5.03, 0), (T, 0, 0.3), (T, 5, 6))).separation

    assert near.least_separation_m == pytest.approx(0.3)
    assert near.least_separation_time_s == pytest.approx(5.03)
    assert near.least_separation_robots == (1, 2)
    assert near.largest_distance_at_end_m == pytest.approx(math.hypot(14.97, 0.3))


def test_the_least_separation_of_many_is_that_of_all_pairs_at_all_times():
    x, y = np.random.default_rng(1).normal(size=(2, 12, len(T))).cumsum(axis=-1)
    near = measure(table(*((T, *track) for track in zip(x, y, strict=True)))).separation

    shares = np.linspace(0, 1, 400)
    fine = [rows[:, :-1, None] + np.diff(rows)[..., None] * shares for rows in (x, y)]
    expected = min(
        np.hypot(fine[0][i] - fine[0][j], fine[1][i] - fine[1][j]).min()
        for i in range(12)
        for j in range(i)
    )
    assert near.least_separation_m == pytest.approx(expected, abs=0.02)
    assert near.least_separation_m <= expected


def test_time_in_saturation():
    v = np.where((T > 2) & (T <= 5), 0.4997, 0.3)
    v[[100, 150]] = -0.5, 0.4994
    fleet = table((T, 0, 0, v))

    assert measure(fleet, vnom=0.5).robots[1].time_in_saturation_s == pytest.approx(3.1)
    assert measure(fleet, vnom=0.3).robots[1].time_in_saturation_s == pytest.approx(20.0)


def test_a_gap_is_not_time_in_saturation():
    t = T[(T <= 5) | (T >= 15)]

    assert measure(table((t, 0, 0, 0.5))).robots[1].time_in_saturation_s == pytest.approx(10.0)


def test_periodic_communications_count_from_the_first_command_on():
    t = np.arange(-5, 11) / 10

    metrics = measure(table((t, 0, 0), (t[::2], 1, 0)))

    assert metrics.communications == {1: 11, 2: 5}
    assert metrics.communication == 'periodic'


def test_triggered_communications(tmp_path):
    run = write_run(tmp_path, table((T, 0, 0), (T, 1, 0), (T, 2, 0)))
    events = [(0.1, 1, 1), (0.2, 1, 0), (0.3, 1, 1), (0.4, 1, 1), (0.1, 2, 0), (0.1, 3, 1)]
    links = {(2, 1): Counts(3, 2, 1, 0.1), (3, 1): Counts(3, 3, 0, 0.1)}
    write_record(record_of(links, events, [(0, 2, 1, 1), (0, 3, 1, 1)], {}), run / 'csv')

    metrics = compute(run)

    assert metrics.communications == {1: 3, 2: 0, 3: 1}
    assert metrics.communication == 'event-triggered'
    assert metrics.messages.triggered_share == pytest.approx(4 / 6)
    assert metrics.messages.loss_ratio == pytest.approx(1 / 6)
    assert metrics.messages.received_by_others == {1: 5, 2: 0, 3: 0}
    assert metrics.messages.mean_interval_s == {1: pytest.approx(0.15), 2: None, 3: None}
    assert '4 states sent (66.7 % of 6 evaluations triggered)' in table_lines(metrics)[-1]
    assert '5 messages received, 1 lost (16.7 %)' in table_lines(metrics)[-1]


def test_position_errors_of_a_formation():
    places = np.array([[-1.0, 0.0], [0.0, 1.0]])
    late = np.where(T < 10, 1.0, 0.0)
    fleet = table((T, 0.1 * T, 0), (T, 0.1 * T - 0.7, 0.4), (T, 0.1 * T, 1 + late))

    errors = measure(fleet, goal=References('formation', places=places)).formation

    assert errors.position_error_final_m == pytest.approx({2: 0.5, 3: 0.0})
    assert errors.position_error_rms_last_quarter_m == pytest.approx({2: 0.5, 3: 0.0})
    assert errors.fleet_position_error_rms_last_quarter_m == pytest.approx(0.5 / math.sqrt(2))


def test_distance_errors_of_a_formation():
    fleet = table((T, 0, 0), (T, 3, 0), (T, 0, 4))

    errors = measure(fleet, goal=References('distances', distance=3.0)).distances

    assert errors.distance_errors_final_m == pytest.approx({'1-2': 0.0, '1-3': 1.0, '2-3': 2.0})
    assert errors.distance_error_final_rms_m == pytest.approx(math.sqrt(5 / 3))
    assert errors.distance_error_rms_last_quarter_m == pytest.approx(math.sqrt(5 / 3))
    assert errors.distance_error_final_largest_m == pytest.approx(2.0)


def test_tracking_errors():
    radius = np.where(T < 10, 2.5, 2.1)
    fleet = table((T, radius * np.cos(0.2 * T), radius * np.sin(0.2 * T)))

    errors = measure(fleet, goal=References('tracking', radius=2.0, rate=0.2)).tracking

    whole = math.sqrt((100 * 0.5**2 + 101 * 0.1**2) / 201)
    assert errors.tracking_error_rms_m == pytest.approx({1: whole})
    assert errors.tracking_error_rms_second_half_m == pytest.approx({1: 0.1})
    assert errors.fleet_tracking_error_rms_m == pytest.approx(whole)


def test_waypoints_of_a_script_of_ones_own(tmp_path):
    # At 0.1 m/s along x the distance to (1, 0) is below 0.055 m from 9.5 s on.
    script = tmp_path / 'mine.py'
    script.write_text('WPL = [[1, 0], [1.5, 0]]\nREACHED = 0.055\ndef control(*_): return 0, 0\n')
    fleet = table((T, 0.1 * T, 0), (T, 3 - 0.1 * T, 0))
    run = write_run(tmp_path / 'run', fleet, algo='mine', script=str(script))

    visits = compute(run, task='waypoints').waypoints

    assert visits.waypoints_m == [[1.0, 0.0], [1.5, 0.0]]
    assert visits.reached_within_m == 0.055
    assert visits.reached_at_s == {1: [9.5, 14.5], 2: [19.5]}
    assert compute(run).task is None


def test_a_list_of_waypoints_is_gone_through_again():
    goal = References('waypoints', waypoints=np.array([[1.0, 0], [0, 0]]), reached=0.01)
    x = np.select([T < 3, T < 6, T < 7], [0, 1, 0], 1)

    assert measure(table((T, x, 0)), goal=goal).waypoints.reached_at_s == {1: [3.0, 6.0, 7.0]}


@pytest.mark.parametrize(
    ('script', 'task', 'part'),
    [
        ('nav_wp.py', 'waypoints', 'waypoints'),
        ('leader_follower_formation.py', 'formation', 'formation'),
        ('leader_follower_formation.py', 'formation', 'waypoints'),
        ('leader_follower_distance_formation.py', 'distances', 'distances'),
        ('traj_tracking.py', 'tracking', 'tracking'),
        ('consensus.py', 'consensus', 'consensus'),
    ],
)
@pytest.mark.parametrize('nb_robots', [1, 3, 12])
def test_the_task_is_that_of_the_built_in_law_wherever_it_was_installed(
    tmp_path, script, task, part, nb_robots
):
    fleet = table(*((T, 0.1 * T, 2.0 * i) for i in range(nb_robots)))
    place = f'C:\\venv\\setcmas_ctrl\\algorithms\\{script}'
    metrics = compute(write_run(tmp_path, fleet, algo=script[:-3], script=place))

    assert metrics.task == task
    needs_two = part in ('formation', 'distances', 'consensus')
    assert (getattr(metrics, part) is None) == (needs_two and nb_robots == 1)
    assert all(map(math.isfinite, numbers(as_dict(metrics))))


def test_a_script_of_ones_own_named_like_a_built_in_is_not_that(tmp_path):
    run = write_run(tmp_path, table((T, 0, 0)), algo='nav_wp', script='/home/me/nav_wp.py')

    assert compute(run).task is None


def test_vnom_is_that_of_the_run_unless_told(tmp_path):
    run = write_run(tmp_path / 'a', table((T, 0, 0, 0.2)), vnom=0.2)

    assert compute(run).robots[1].time_in_saturation_s == pytest.approx(20.0)
    assert compute(run, vnom=0.4).robots[1].time_in_saturation_s == 0.0
    assert compute(write_run(tmp_path / 'b', table((T, 0, 0, 0.2)))).vnom_m_s == 0.5


def test_a_robot_that_appears_late_and_one_that_goes_early():
    late, early = T[T >= 4], T[T <= 12]
    metrics = measure(table((T, 0, 0), (late, 1, 0), (early, 0, 2)))

    assert metrics.consensus.start_time_s == 4.0
    assert metrics.consensus.end_time_s == 12.0
    assert metrics.separation.least_separation_robots == (1, 2)
    assert metrics.separation.largest_distance_at_end_m == pytest.approx(math.sqrt(5))
    assert metrics.communications == {1: 201, 2: 161, 3: 121}


def test_robots_that_are_never_there_together():
    metrics = measure(table((T[T < 5], 0, 0), (T[T > 8], 1, 0)))

    assert metrics.separation is None
    assert metrics.consensus is None
    assert all(map(math.isfinite, numbers(as_dict(metrics))))
    assert table_lines(metrics)


@pytest.mark.parametrize('t', [[0.0], [0.03], [-0.5, 0.02], [0.0, 5.0]])
def test_a_handful_of_rows(t):
    t = np.array(t)
    metrics = measure(table((t, 0, 0), (t, np.nan, np.nan, np.nan), (t, 1, 0)))

    assert all(map(math.isfinite, numbers(as_dict(metrics))))
    assert metrics.robots[2].largest_speed_m_s is None
    assert table_lines(metrics)


def test_rows_before_the_first_command_do_not_count():
    t = np.arange(-50, 51) / 10
    metrics = measure(table((t, np.minimum(t, 0), 0, 0.5), (t, 3, 0)))

    assert metrics.robots[1].path_length_m == 0.0
    assert metrics.robots[1].time_in_saturation_s == pytest.approx(5.0)
    assert metrics.separation.least_separation_time_s == 0.0
    assert metrics.duration_s == pytest.approx(5.0)


def test_equal_runs_give_equal_files_whatever_the_calls_took(tmp_path):
    fleet = simulate('leader_follower_formation', 3, 5).table
    run = write_run(tmp_path / 'run', fleet, algo='leader_follower_formation')
    for name, seconds in (('a', 1e-3), ('b', 2e-3)):
        write_yaml(compute(run, call_times={1: seconds}), tmp_path / name)

    text = (tmp_path / 'a').read_text()
    assert text == (tmp_path / 'b').read_text()
    assert 'call' not in text
    assert list(yaml.safe_load(text))[:5] == [
        'task', 'duration_s', 'vnom_m_s', 'communication', 'robots',
    ]  # fmt: skip


@pytest.mark.parametrize('nb_robots', [1, 8, MOST_ROBOTS_IN_ROWS, MOST_ROBOTS_IN_ROWS + 1])
def test_the_table_has_a_row_for_each_robot_or_summarises(nb_robots):
    fleet = table(*((T, i, 0.1 * T) for i in range(nb_robots)))
    calls = dict.fromkeys(range(1, nb_robots + 1), 0.0015)
    lines = table_lines(measure(fleet, call_times=calls))
    text = '\n'.join(lines)

    assert max(map(len, lines)) <= 99
    assert '1.500' in text
    assert 'nan' not in text
    rows = [line.split()[0] for line in lines[3 : 3 + min(nb_robots, MOST_ROBOTS_IN_ROWS)]]
    if nb_robots <= MOST_ROBOTS_IN_ROWS:
        assert rows == [f'tb3_{i}' for i in range(1, nb_robots + 1)]
    else:
        assert rows[:3] == ['least', 'mean', 'largest']
    assert ('least separation: 1.00 m at 0.0 s between robots 1 and 2' in text) == (nb_robots > 1)


@needs_recordings
def test_the_recording_of_the_ros_1_stack():
    metrics = compute(CONSENSUS)

    assert list(metrics.robots) == list(range(1, 9))
    agreement = metrics.consensus
    # Four robots start at sqrt(50) m from the centre, four at 5 m.
    assert agreement.disagreement_at_start_m == pytest.approx(math.sqrt(37.5), abs=0.05)
    assert agreement.disagreement_at_end_m < 0.02 * agreement.disagreement_at_start_m
    assert agreement.settling_time_5_percent_s < agreement.settling_time_2_percent_s < 40
    for motion in metrics.robots.values():
        assert motion.largest_speed_m_s == pytest.approx(0.5)
        assert 4.0 < motion.path_length_m < 9.0
        assert 0 < motion.time_in_saturation_s < motion.path_length_m / 0.5 + 0.1


@pytest.mark.parametrize(
    ('script', 'task', 'message'),
    [
        ('', 'waypoints', 'defines no WPL'),
        ('WPL = [1, 2]', 'waypoints', r"WPL is '\[1, 2\]'; accepted are points"),
        ('PLACES = [(1, 0)]', 'formation', '1 places for 2 followers'),
        ('def places_of(n): return 1 / 0', 'formation', 'ZeroDivisionError'),
        ('D = "far"', 'distances', "D is 'far'; accepted is a number"),
        ('R = 2', 'tracking', 'defines no W'),
        ('', 'dance', "task 'dance' is unknown; accepted are consensus"),
    ],
)
def test_numbers_that_a_script_does_not_define(tmp_path, script, task, message):
    path = tmp_path / 'mine.py'
    path.write_text(f'{script}\ndef control(*_): return 0, 0\n')
    run = write_run(tmp_path / 'run', table((T, 0, 0), (T, 1, 0), (T, 2, 0)))

    with pytest.raises(SetcmasError, match=message):
        compute(run, task=task, algo=str(path))


@pytest.mark.parametrize(
    ('file', 'content', 'message'),
    [
        ('run.yaml', 'parameters: [', r"run\.yaml' cannot be read"),
        ('run.yaml', 'parameters: 3', r"run\.yaml' is no record of a run"),
        ('run.yaml', 'parameters: {vnom: fast}', "vnom 'fast' is not a speed"),
        ('csv/fleet.csv', 't,robot\n1,2\n', r'fleet\.csv.*line 1'),
        ('csv/fleet.csv', 't,robot,x,y,theta,v,omega\n-1,1,0,0,0,0,0\n', 'no row at t >= 0'),
        ('csv/communication.csv', 'sender\n1\n', r'communication\.csv. is damaged'),
        (
            'csv/communication.csv',
            f'{MESSAGES}\n1,all,2,x,0,\n',
            r'communication\.csv. is damaged',
        ),
    ],
)
def test_damaged_files(tmp_path, file, content, message):
    run = write_run(tmp_path, table((T, 0, 0)))
    (run / file).write_text(content)

    with pytest.raises(SetcmasError, match=message):
        compute(run)


def test_a_task_without_a_script(tmp_path):
    with pytest.raises(SetcmasError, match='name it with --algo'):
        compute(write_run(tmp_path, table((T, 0, 0))), task='tracking')


def test_a_bag_is_measured_as_its_csv_files_are(tmp_path, make, write_bag, capsys):
    messages = []
    for i in range(50):
        values = {'pose.pose.position.x': 0.05 * i, 'pose.pose.orientation.w': 1.0}
        messages.append(('/tb3_1/odom', i / 10, make('nav_msgs/msg/Odometry', values)))
    bag = write_bag(tmp_path / 'out' / 'bag', messages)
    (tmp_path / 'out' / 'run.yaml').write_text('parameters: {algo: nav_wp, vnom: 0.4}')

    assert main(['metrics', str(bag)]) == 0
    of_bag = (tmp_path / 'out' / 'metrics.yaml').read_bytes()
    assert 'tb3_1      2.45' in capsys.readouterr().out
    assert yaml.safe_load(of_bag)['task'] == 'waypoints'
    assert main(['metrics', str(tmp_path / 'out')]) == 0
    assert not (tmp_path / 'out' / 'csv').exists()
    assert main(['bag_to_csv', str(bag)]) == 0
    assert main(['metrics', str(tmp_path / 'out')]) == 0
    assert (tmp_path / 'out' / 'metrics.yaml').read_bytes() == of_bag

    lone = write_bag(tmp_path / 'lab', messages)
    assert main(['metrics', str(lone)]) == 0
    assert (tmp_path / 'lab_metrics.yaml').is_file()


def test_a_bag_without_robots(tmp_path, write_bag, points, capsys):
    assert main(['metrics', str(write_bag(tmp_path / 'bag', points))]) == 2
    assert 'holds no odometry of robots' in capsys.readouterr().err
