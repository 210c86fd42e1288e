import math

import numpy as np
import pytest

from setcmas_ctrl.communication.graph import (
    PRESETS,
    CommunicationGraph,
    Segment,
    checked_adjacency,
    complete,
    directed_ring,
    laplacian,
    load_graph,
    neighbours,
    path,
    ring,
    star,
)
from setcmas_simu.errors import SetcmasError

NOWHERE = np.zeros((2, 4))


def senders_of(adjacency):
    return [neighbours(adjacency, robot + 1) for robot in range(len(adjacency))]


def test_presets():
    assert senders_of(complete(3)) == [[2, 3], [1, 3], [1, 2]]
    assert senders_of(ring(4)) == [[2, 4], [1, 3], [2, 4], [1, 3]]
    assert senders_of(path(4)) == [[2], [1, 3], [2, 4], [3]]
    assert senders_of(star(4)) == [[2, 3, 4], [1], [1], [1]]
    assert senders_of(directed_ring(4)) == [[2], [3], [4], [1]]


@pytest.mark.parametrize('preset', PRESETS.values())
def test_presets_of_small_fleets_have_no_link_to_itself(preset):
    assert preset(1).tolist() == [[0.0]]
    assert preset(2).tolist() == [[0.0, 1.0], [1.0, 0.0]]
    assert preset(9).max() == 1.0


def test_the_laplacian_counts_weights_by_receiver():
    assert laplacian(np.array([[0.0, 2.0], [0.5, 0.0]])).tolist() == [[2.0, -2.0], [-0.5, 0.5]]


def graph(*durations, repeat=False):
    matrices = [path(4), ring(4), star(4)]
    return CommunicationGraph(
        [Segment(str(k), d, matrices[k]) for k, d in enumerate(durations)], repeat
    )


@pytest.mark.parametrize(
    ('repeat', 'names'), [(False, '000 001 111 222 222'), (True, '000 001 111 222 000')]
)
def test_segments_follow_each_other(repeat, names):
    switching = graph(5, 3, 4, repeat=repeat)
    times = [0, 1, 2, 3, 4, 5, 6, 7, 7.9, 8, 11, 11.9, 12, 14, 16.9]

    found = ''.join(switching.segment(t).name for t in times)

    assert found == names.replace(' ', '')


def test_a_segment_begins_at_its_time_in_spite_of_rounding():
    switching = graph(0.6, math.inf)

    assert switching.segment(3 * 0.2).name == '1'
    assert switching.segment(0.1 + 0.1 + 0.1 + 0.1 + 0.1 + 0.1).name == '1'


def test_the_range_cuts_links_and_moves_with_the_robots():
    segments = [Segment('', math.inf, checked_adjacency(2.0 * path(3), 3))]
    near = CommunicationGraph(segments, reach=3.0)

    assert senders_of(near.adjacency(0, np.array([[0.0, 3.0, 6.1], [0, 0, 0]]))) == [[2], [1], []]
    weights = near.adjacency(0, np.array([[0.0, 1.0, 0.5], [0, 0, np.nan]]))
    assert weights.tolist() == [[0, 2, 0], [2, 0, 0], [0, 0, 0]]


def test_what_is_complete():
    whole = [Segment('', math.inf, complete(3))]

    assert CommunicationGraph(whole).is_complete
    assert not CommunicationGraph(whole, reach=5.0).is_complete
    assert not CommunicationGraph([Segment('', math.inf, path(3))]).is_complete
    switching = [Segment('', 1.0, path(3)), *whole]
    assert not CommunicationGraph(switching).is_complete


def test_a_graph_cannot_be_changed_by_those_who_get_it():
    switching = CommunicationGraph([Segment('', math.inf, complete(4))], reach=1.0)

    with pytest.raises(ValueError, match='read-only'):
        switching.adjacency(0, NOWHERE)[0, 1] = 5
    with pytest.raises(ValueError, match='read-only'):
        complete(3)[0, 1] = 5


@pytest.mark.parametrize(
    ('matrix', 'message'),
    [
        ([[0, 1]], r'shape \(1, 2\).*needs \(2, 2\)'),
        ([[0, -1], [1, 0]], 'not negative'),
        ([[0, float('nan')], [1, 0]], 'finite'),
        ([[1, 1], [1, 0]], 'robots have no links to themselves'),
        ([[0, 1], [1]], 'not a square of numbers'),
        ([[0, 'a'], [1, 0]], "not a square of numbers: .*'a'"),
    ],
)
def test_matrices_that_are_no_graph(matrix, message):
    with pytest.raises(SetcmasError, match=message):
        checked_adjacency(matrix, 2)


@pytest.fixture
def load(tmp_path):
    def load(text):
        path = tmp_path / 'graph.yaml'
        path.write_text(text)
        return load_graph(path)

    return load


@pytest.mark.parametrize(
    ('text', 'adjacency'),
    [
        ('graph: directed_ring', [[0, 1, 0], [0, 0, 1], [1, 0, 0]]),
        ('edges:\n  - 1 - 2\n  - 3 <- 2: 0.5\n  - 1->3', [[0, 1, 0], [1, 0, 0], [1, 0.5, 0]]),
    ],
)
def test_a_preset_and_edges(load, text, adjacency):
    (segment,) = load(f'{text}\n').segments(3)
    assert segment.adjacency.tolist() == adjacency


def test_segments(load):
    description = load(
        'segments:\n'
        '  - {name: apart, duration: 10, edges: [1 - 2, 3 - 4]}\n'
        '  - {duration: 5, graph: complete}\n'
        'repeat: true\n'
    )
    apart, together = description.segments(4)

    assert (apart.name, apart.duration) == ('apart', 10.0)
    assert (together.name, together.duration) == ('segment 2', 5.0)
    np.testing.assert_array_equal(apart.adjacency, np.kron(np.eye(2), 1 - np.eye(2)))
    np.testing.assert_array_equal(together.adjacency, 1 - np.eye(4))
    assert description.repeat


@pytest.mark.parametrize(
    ('text', 'line', 'message'),
    [
        ('', 1, 'has no graph'),
        ('edges: [', 1, 'not YAML'),
        ('graph: rong\n', 1, "graph is 'rong'; did you mean ring? It must be complete"),
        (
            '# comment\nedge:\n  - 1 - 2\n',
            2,
            "there is no key 'edge'; did you mean edges? It must be one of segments",
        ),
        ('edges:\n  - 1 - 2\n  - 1 + 2\n', 3, "edges[1] is '1 + 2'; it must be '1 - 2'"),
        ('edges:\n  - 1 - 2\n  - 2 - 2\n', 3, 'robots have no links to themselves'),
        ('edges:\n  - 1 - 2: heavy\n', 2, "is 'heavy'; it must be a number of at least 0"),
        (
            'edges:\n  - [1, 2]\n',
            2,
            "edges[0] is [1, 2]; it must be '1 - 2' (both directions",
        ),
        ('edges:\n  - 1 - 2\n  - 1 <- 2: 0.5\n', 3, "'1 <- 2' appears twice; remove one"),
        ('edges: []\n', 1, 'a non-empty list'),
        ('edges:\n  - {1 - 2: 1, 2 - 3: 1}\n', 2, 'or with a weight: 1 - 2: 0.5'),
        ('graph: ring\nedges: [1 - 2]\n', 1, 'has graph and edges; it must be one of'),
        ('graph: ring\nrepeat: true\n', 2, "'repeat' needs 'segments'"),
        ('segments:\n  - {graph: ring}\n  - {graph: path}\n', 1, 'needs a duration'),
        (
            'segments:\n  - {graph: ring, duration: 0}\n',
            2,
            'duration is 0; it must be above 0 s',
        ),
        ('segments:\n  - {graph: ring}\nedges: [1 - 2]\n', 3, "'edges' belongs in the segments"),
    ],
)
def test_mistakes_are_reported_with_their_line(load, text, line, message):
    with pytest.raises(SetcmasError) as error:
        load(text)

    assert f'graph.yaml, line {line}: ' in str(error.value)
    assert message in str(error.value)
    assert '\n' not in str(error.value)


def test_a_graph_of_another_fleet(load):
    with pytest.raises(SetcmasError, match='line 3: it names robot 9; the fleet has robots 1 to'):
        load('edges:\n  - 1 - 2\n  - 2 - 9\n').segments(8)
