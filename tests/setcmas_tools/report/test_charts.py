import numpy as np
from report_pages import unpacked

from setcmas_tools.offline.engine import simulate
from setcmas_tools.replay.curves import curves
from setcmas_tools.report.charts import charts_entry


def test_curves_are_those_of_the_plots_with_the_other_run_beside_them():
    run, other = (simulate('consensus', 3, 4.0, seed=1, settings={'K': k}) for k in (0.02, 0.05))
    t = np.arange(41) / 10
    charts = {chart['name']: chart for chart in charts_entry(run, other, t)}

    assert list(charts) == ['Difference', 'Disagreement', 'Least separation', 'Speed']
    for own, curve in zip(list(charts.values())[1:], curves(run), strict=True):
        for robot, values in curve.values.items():
            assert np.allclose(unpacked(own['values'][robot]), values, atol=6e-5, equal_nan=True)
    disagreement = charts['Disagreement']
    assert unpacked(disagreement['other'][0])[-1] < unpacked(disagreement['values'][0])[-1]


def test_at_other_times_nothing_is_known():
    run = simulate('consensus', 2, 1.0)
    chart = charts_entry(run, None, np.array([0.5, 0.55, 7.0]))[0]

    assert [step is None for step in chart['values'][0]] == [False, True, True]
    assert 'other' not in chart
