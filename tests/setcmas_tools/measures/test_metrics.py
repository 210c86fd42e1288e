import math

import numpy as np
import pytest
import yaml
from metrics_runs import T, compute, numbers, table, write_run
from plugins import add_plugins
from runs import measure, run_of

from launch_scripts.cli import main
from setcmas_ctrl.laws.references import References
from setcmas_simu.errors import SetcmasError
from setcmas_tools import simulate
from setcmas_tools.measures import metrics as metrics_module
from setcmas_tools.measures.metric import METRICS, Value
from setcmas_tools.measures.metrics import (
    MOST_ROBOTS_IN_ROWS,
    as_dict,
    fleet_lines,
    theory_lines,
    write_yaml,
)
from setcmas_tools.run.run_info import RunInfo, write_info
from setcmas_tools.run.run_records import Counts, record_of
from setcmas_tools.run.run_tables import write_communication


def sent(metrics):
    return {robot: motion['communications'] for robot, motion in metrics['robots'].items()}


def test_periodic_communications_count_from_the_first_command_on():
    t = np.arange(-5, 11) / 10

    metrics = measure(table((t, 0, 0), (t[::2], 1, 0)))

    assert sent(metrics) == {1: 11, 2: 5}
    assert metrics.communication == 'periodic'


def test_triggered_communications(tmp_path):
    run = write_run(tmp_path, table((T, 0, 0), (T, 1, 0), (T, 2, 0)))
    events = [(0.1, 1, 1), (0.2, 1, 0), (0.3, 1, 1), (0.4, 1, 1), (0.1, 2, 0), (0.1, 3, 1)]
    links = {(2, 1): Counts(3, 2, 1, 0.1), (3, 1): Counts(3, 3, 0, 0.1)}
    write_communication(record_of(links, events, [(0, 2, 1, 1), (0, 3, 1, 1)], {}), run / 'csv')

    metrics = compute(run)

    assert sent(metrics) == {1: 3, 2: 0, 3: 1}
    assert metrics.communication == 'event-triggered'
    assert metrics['messages'].triggered_share == pytest.approx(4 / 6)
    assert metrics['messages'].loss_ratio == pytest.approx(1 / 6)
    assert metrics['messages'].received_by_others == {1: 5, 2: 0, 3: 0}
    assert metrics['messages'].mean_interval_s == {1: pytest.approx(0.15), 2: None, 3: None}
    assert '4 states sent (66.7 % of 6 evaluations triggered)' in str(metrics).splitlines()[-1]
    assert '5 messages received, 1 lost (16.7 %)' in str(metrics).splitlines()[-1]


def test_a_robot_that_appears_late_and_one_that_goes_early():
    late, early = T[T >= 4], T[T <= 12]
    metrics = measure(table((T, 0, 0), (late, 1, 0), (early, 0, 2)))

    assert metrics['consensus'].start_time_s == 4.0
    assert metrics['consensus'].end_time_s == 12.0
    assert metrics['separation'].least_separation_robots == (1, 2)
    assert metrics['separation'].largest_distance_at_end_m == pytest.approx(math.sqrt(5))
    assert sent(metrics) == {1: 201, 2: 161, 3: 121}


def test_robots_that_are_never_there_together():
    metrics = measure(table((T[T < 5], 0, 0), (T[T > 8], 1, 0)))

    assert 'separation' not in metrics
    assert 'consensus' not in metrics
    assert all(map(math.isfinite, numbers(as_dict(metrics))))
    assert str(metrics)


@pytest.mark.parametrize('t', [[0.0], [0.03], [-0.5, 0.02], [0.0, 5.0]])
def test_a_handful_of_rows(t):
    t = np.array(t)
    metrics = measure(table((t, 0, 0), (t, np.nan, np.nan, np.nan), (t, 1, 0)))

    assert all(map(math.isfinite, numbers(as_dict(metrics))))
    assert metrics['robots'][2]['largest_speed_m_s'] is None
    assert str(metrics)


@pytest.mark.parametrize('nb_robots', [1, 8, MOST_ROBOTS_IN_ROWS, MOST_ROBOTS_IN_ROWS + 1])
def test_the_table_has_a_row_for_each_robot_or_summarises(nb_robots):
    fleet = table(*((T, i, 0.1 * T) for i in range(nb_robots)))
    text = str(measure(fleet))
    lines = text.splitlines()

    assert max(map(len, lines)) <= 99
    assert 'nan' not in text
    rows = [line.split()[0] for line in lines[3 : 3 + min(nb_robots, MOST_ROBOTS_IN_ROWS)]]
    if nb_robots <= MOST_ROBOTS_IN_ROWS:
        assert rows == [f'tb3_{i}' for i in range(1, nb_robots + 1)]
    else:
        assert rows[:3] == ['least', 'mean', 'largest']
    assert ('least separation: 1.00 m at 0.0 s between robots 1 and 2' in text) == (nb_robots > 1)


def test_a_bag_is_measured_as_its_csv_files_are(tmp_path, make, write_bag, capsys):
    messages = []
    for i in range(50):
        values = {'pose.pose.position.x': 0.05 * i, 'pose.pose.orientation.w': 1.0}
        messages.append(('/tb3_1/odom', i / 10, make('nav_msgs/msg/Odometry', values)))
    task = References('waypoints', {'WPL': [[1.0, 0.0]], 'REACHED': 0.1}).encoded()
    messages.append(('/task', 0.0, make('std_msgs/msg/String', {'data': task})))
    bag = write_bag(tmp_path / 'out' / 'bag', messages)
    write_info(RunInfo(scenario={'vnom': 0.4}), tmp_path / 'out')

    assert main(['metrics', str(bag)]) == 0
    of_bag = (tmp_path / 'out' / 'metrics.yaml').read_bytes()
    assert 'tb3_1      2.45' in capsys.readouterr().out
    assert yaml.safe_load(of_bag)['task'] == 'waypoints'
    assert yaml.safe_load(of_bag)['vnom_m_s'] == 0.4
    assert main(['metrics', str(tmp_path / 'out')]) == 0
    assert not (tmp_path / 'out' / 'csv').exists()
    assert main(['bag_to_csv', str(bag)]) == 0
    assert main(['metrics', str(tmp_path / 'out')]) == 0
    assert (tmp_path / 'out' / 'metrics.yaml').read_bytes() == of_bag

    lone = write_bag(tmp_path / 'lab', messages)
    assert main(['metrics', str(lone)]) == 0
    assert (tmp_path / 'lab_metrics.yaml').is_file()


def test_a_run_that_was_never_commanded_has_no_metrics(tmp_path):
    run = write_run(tmp_path, table((T - 99, 0, 0)))

    with pytest.raises(SetcmasError, match='no row has t >= 0'):
        compute(run)


def test_a_strange_task_in_a_bag_is_reported(tmp_path, make, write_bag, capsys):
    odometry = make('nav_msgs/msg/Odometry', {'pose.pose.orientation.w': 1.0})
    messages = [('/tb3_1/odom', i / 10, odometry) for i in range(20)]
    messages.append(('/task', 0.0, make('std_msgs/msg/String', {'data': '{"task": 3}'})))

    assert main(['metrics', str(write_bag(tmp_path / 'bag', messages))]) == 0
    reported = '/task is not understood and ignored: it must be a JSON object with task'
    assert reported in capsys.readouterr().err


def test_a_bag_without_robots(tmp_path, write_bag, points, capsys):
    assert main(['metrics', str(write_bag(tmp_path / 'bag', points))]) == 2
    assert 'holds no odometry of robots' in capsys.readouterr().err


@pytest.mark.parametrize('number', [2, 2.0, np.float64(2), np.float32(2), np.int64(2)])
def test_a_metric_may_return_a_number(monkeypatch, number):
    add_plugins(monkeypatch, METRICS, height=lambda _: number)

    metrics = measure(table((T, 0, 0)))

    assert 'height: 2.00' in str(metrics).splitlines()
    assert as_dict(metrics)['height'] == {'value': 2.0, 'unit': ''}


WRONG = {'dict': {'a': 1}, 'str': '2 m', 'ndarray': np.zeros(3), 'bool': True}


@pytest.mark.parametrize('value', ['2 m', {1: '2 m'}])
def test_a_value_is_a_number(value):
    with pytest.raises(ValueError, match='format code'):
        Value('height', value)


@pytest.mark.parametrize('kind', WRONG)
def test_what_is_no_metric_is_reported_in_one_line_with_its_package(tmp_path, monkeypatch, kind):
    reason = f'returned a value of type {kind}; it must return a number'
    add_plugins(monkeypatch, METRICS, height=lambda _: WRONG[kind])
    messages = []

    metrics = metrics_module.measure(run_of(table((T, 0, 0))), messages.append)

    assert 'height' not in metrics
    (message,) = messages
    assert message.startswith(f"metric 'height' of package my-lab 1.0 {reason}")
    assert '\n' not in message
    write_yaml(metrics, tmp_path / 'metrics.yaml')


def told(*arguments, **options):
    """The lines on a run of consensus."""
    return fleet_lines(simulate(*arguments, **options).metrics())


def test_the_first_run_of_a_newcomer_reads_as_a_success():
    sentence, *others = told('consensus', 8, 40)

    assert sentence == (
        'The robots met: at most 0.04 m apart at the end. Rate 0.502 1/s, theory 0.527.'
    )
    assert [line.partition(':')[0] for line in others] == ['disagreement', 'centre at the end']


@pytest.mark.parametrize(
    ('options', 'sentence'),
    [
        ({'set': {'K': 2.0}}, '1/s, theory 2.55 (the speed limit was reached until 14.0 s).'),
        ({'duration': 5}, 'The robots did not meet: at most 9.45 m apart at the end.'),
    ],
)
def test_the_sentence_fits_the_run(options, sentence):
    assert told('consensus', 8, **{'duration': 40} | options)[0].endswith(sentence)


def test_contacts_count_where_robots_are_kept_apart_or_need_not_meet():
    apart = told('consensus', 3, 10, filter='barrier')
    assert any(line.startswith('least separation') for line in apart)
    lines = told('nav_wp', 2, 1, poses=np.zeros((3, 2)))
    assert any(line.startswith('collisions') for line in lines)


def test_what_theory_says_is_told_only_when_asked():
    parts = simulate('consensus', 3, 5).metrics()

    assert not any(line.startswith('theory') for line in fleet_lines(parts))
    assert theory_lines(parts)[0].startswith('theory: convergence rate 0.5 1/s')
    parts = simulate('nav_wp', 1, 1).metrics()
    assert theory_lines(parts) == ['theory: nothing is predicted for this law']


def test_equal_runs_have_equal_metrics_by_the_names_of_the_file():
    first, again, slower = (
        simulate('consensus', 2, 5.0, vnom=v).metrics() for v in (0.5, 0.5, 0.2)
    )

    assert first == again != slower
    assert 1 in first['robots']
    assert [*first['robots']] == [1, 2]
    assert first['consensus']['start_time_s'] == first['consensus'].start_time_s == 0.0
    with pytest.raises(AttributeError, match="has no value 'speed'"):
        first['consensus'].speed  # noqa: B018
