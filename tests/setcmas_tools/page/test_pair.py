import base64
import io

from PIL import Image

from setcmas_tools.offline.engine import simulate
from setcmas_tools.page.pair import Pair, embedded_pictures
from setcmas_tools.plots.plot import plots_of
from setcmas_tools.plots.style import plot_style


def test_two_runs_are_measured_and_drawn_beside_each_other():
    run, other = (simulate('consensus', 2, 3.0, set={'K': k}) for k in (0.02, 0.05))
    pair = Pair('slow', run, 'fast', other)
    table, below = pair.metrics()
    with plot_style():
        names = [name for name, _ in pair.figures()]

    assert str(table).splitlines()[0].split() == ['slow', 'fast', 'difference']
    assert below == []
    assert names[:3] == ['paths', 'distances', 'trajectories']
    assert pair.differences == ['set.K: 0.02 -> 0.05']
    assert pair.headline.startswith('fast is nearest')


def test_one_run_has_the_table_of_its_robots():
    table, below = Pair('one', simulate('consensus', 2, 3.0)).metrics()

    assert len(table.rows) == 2
    assert below[0].startswith('least separation')


def test_each_plot_is_there_and_small(failed_run):
    found = list(embedded_pictures(Pair('failed', failed_run)))

    assert [one.name for one in found] == list(plots_of(failed_run))
    for one in found:
        kind, _, content = one.address.partition(';base64,')
        decoded = base64.b64decode(content)
        assert len(decoded) < 100_000
        if kind == 'data:image/png':
            picture = Image.open(io.BytesIO(decoded))
            assert picture.width > 400
            assert picture.mode == 'P'
        else:
            assert kind == 'data:image/svg+xml'
            assert b'<svg' in decoded
