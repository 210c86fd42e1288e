from setcmas_tools import simulate
from setcmas_tools.compare.ladder import Rung
from setcmas_tools.compare.ladder_plot import ladder_figure
from setcmas_tools.plots.style import plot_style


def test_a_panel_for_each_rung_and_the_largest_step_in_bold():
    run = simulate('consensus', 3, 10.0)
    rungs = [
        Rung('single integrators', run),
        Rung('sampled', run, 0.1),
        Rung('as recorded', run, 0),
    ]

    with plot_style():
        figure = ladder_figure(rungs)

    shown = [axes for axes in figure.axes if axes.axison]
    assert [axes.get_title('left') for axes in shown] == [
        '1  single integrators', '2  sampled', '3  as recorded',
    ]  # fmt: skip
    assert [axes.xaxis.label.get_fontweight() for axes in shown] == ['normal', 'bold', 'normal']
    assert '0.100 m (RMS) from the rung before' in shown[1].get_xlabel()
    assert 'dots: every 0.5 s' in figure.get_supxlabel()
