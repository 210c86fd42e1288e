from setcmas_tools.offline.engine import simulate
from setcmas_tools.plots.style import plot_style
from setcmas_tools.report.pair import Pair


def test_two_runs_are_measured_and_drawn_beside_each_other():
    run, other = (simulate('consensus', 2, 3.0, settings={'K': k}) for k in (0.02, 0.05))
    pair = Pair('slow', run, 'fast', other)
    table, below = pair.metrics('simple')
    with plot_style():
        names = [name for name, _ in pair.figures()]

    assert table.splitlines()[0].split() == ['slow', 'fast', 'difference']
    assert below == []
    assert names[:3] == ['paths', 'distances', 'trajectories']
    assert pair.differences == ['set.K: 0.02 -> 0.05']
    assert pair.beside.startswith('fast is nearest')


def test_one_run_has_the_table_of_its_robots():
    table, below = Pair('one', simulate('consensus', 2, 3.0)).metrics('html')

    assert table.startswith('<table>')
    assert table.count('<tr>') == 3
    assert below[0].startswith('least separation')
