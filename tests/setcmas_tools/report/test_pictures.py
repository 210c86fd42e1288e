import base64
import io

from PIL import Image

from setcmas_tools.plots.plot import plots_of
from setcmas_tools.report.pair import Pair
from setcmas_tools.report.pictures import embedded_pictures


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
