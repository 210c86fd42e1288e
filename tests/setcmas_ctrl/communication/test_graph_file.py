import numpy as np
import pytest

from setcmas_ctrl.communication.graph_file import load_graph
from setcmas_simu.errors import SetcmasError


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
