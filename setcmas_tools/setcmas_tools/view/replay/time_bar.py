"""Time bar of a run that is shown again: slider, buttons, and charts with its cursor."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import viser

from setcmas_tools.replay.curves import Curve
from setcmas_tools.view.page.keys import (
    BACK,
    END,
    FASTER,
    FORTH,
    HOME,
    PAUSE,
    PLAY,
    SLOWER,
    TIME_BAR,
)
from setcmas_tools.view.replay.charts import add_charts, cursor_style

HEIGHT_PX = 300
"""What the bar covers of the scene."""

_GAP_PX = 12
_BESIDE_PX = 372  # the panel on the right, and what is free around it
# viser's windows have a width in pixels, whatever that of the browser is.
_STYLE = (
    f'<style>[data-floating-window]:has(.{TIME_BAR})'
    f'{{width:max(320px,calc(100vw - {_BESIDE_PX}px))!important}}'
    f'.{TIME_BAR}{{padding:0 12px;font-size:14px;font-variant-numeric:tabular-nums}}</style>'
)
_FINE_S = 0.01, 0.05  # steps of the slider of short runs, and of others
_SHORT_S = 1.0
Wish = Callable[[], None]


class TimeBar:
    """A panel below the scene."""

    def __init__(
        self,
        gui: viser.GuiApi,
        span: tuple[float, float],
        curves: Sequence[Curve],
        wishes: Mapping[str, Wish],
        seek: Callable[[float], None],
    ) -> None:
        """Build the panel.

        Args:
            gui: Of the page.
            span: Begin and end of the run in s.
            curves: What to chart.
            wishes: What each button of `page.keys` does.
            seek: Takes the time in s that somebody has dragged the slider to.
        """
        self._t0, self._t1 = span
        self._shown = self._dragged = self._t0
        step = _FINE_S[self._t1 - self._t0 > _SHORT_S]
        panel = gui.add_panel()
        with panel.add_tab('Replay', viser.Icon.PLAYER_PLAY):
            self._text = gui.add_html('')
            self._slider = gui.add_slider('t (s)', self._t0, self._t1, step, self._t0)
            self._buttons = gui.add_button_group('', _buttons(PLAY))
            add_charts(gui, curves, span)
            self._cursor = gui.add_html('')
        panel.float(x=_GAP_PX, y=-_GAP_PX)

        @self._slider.on_update
        async def _(event: viser.GuiEvent[viser.GuiSliderHandle[float]]) -> None:
            if event.client_id is not None:  # not by this program
                self._dragged = float(event.target.value)
                seek(self._dragged)

        @self._buttons.on_click
        async def _(event: viser.GuiEvent[viser.GuiButtonGroupHandle]) -> None:
            name = str(event.target.value)
            wishes[PLAY if name == PAUSE else name]()

    def show(self, t: float, text: str, paused: bool) -> None:
        """Show a time in s, and what is said of it (HTML)."""
        if t not in (self._shown, self._dragged):  # nothing pulls it back from under a hand
            self._slider.value = t  # type: ignore[misc]  # it has a setter
        self._shown = t
        self._text.content = f'{_STYLE}<div class="{TIME_BAR}">{text}</div>'
        self._buttons.options = _buttons(PLAY if paused else PAUSE)
        share = (t - self._t0) / max(self._t1 - self._t0, 1e-9)
        self._cursor.content = cursor_style(share)


def _buttons(play: str) -> tuple[str, ...]:
    return (HOME, BACK, play, FORTH, END, SLOWER, FASTER)
