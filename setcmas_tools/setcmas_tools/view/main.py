"""Browser view process: a running fleet on a page until a signal asks to stop."""

from __future__ import annotations

import argparse
import sys
import time

from setcmas_expe.pause.console import UNKNOWN, Action, OperatorRequest
from setcmas_expe.safety.stalls import time_since_boot
from setcmas_simu.reports.reports import Ready
from setcmas_simu.ros.process import FleetNode, RosProcess, node_main
from setcmas_tools.view.commands import FleetCommands
from setcmas_tools.view.fleet_scene import FleetScene
from setcmas_tools.view.law_name import LawName
from setcmas_tools.view.model.fleet_state import FleetState
from setcmas_tools.view.page.announcement import announce
from setcmas_tools.view.page.browser_options import BrowserOptions
from setcmas_tools.view.page.buttons import Actions
from setcmas_tools.view.page.desktop import Opener
from setcmas_tools.view.page.page import Page
from setcmas_tools.view.prompt_browsers import PromptBrowsers
from setcmas_tools.view.topics import ViewedTopics

_FRAME_S = 0.05
_IDLE_S = 0.5
_LOOK_S = 1.0


class BrowserView:
    """Takes what the topics tell, and draws it while somebody looks."""

    def __init__(self, process: RosProcess, page: Page, options: BrowserOptions) -> None:
        """Build the page's content.

        Args:
            process: Asked whether to stop; an experiment that has started it takes starts.
            page: Where to draw.
            options: What the page lets one do.
        """
        self._process = process
        self._page = page
        node = FleetNode('browser_view')
        self._state = FleetState()
        self._topics = ViewedTopics(node, self._state)
        self._law = LawName(process, node, self._state)
        self._commands = None if options.read_only else FleetCommands(node)
        self._may_start = options.operator
        self._browsers = PromptBrowsers(page.server)
        self._scene = FleetScene(page.server, self._state, self._actions())

    def run(self) -> None:
        """Draw until a signal asks to stop."""
        next_look = 0.0
        opener = Opener(self._page.url)
        self._process.launcher.report(Ready())
        while not self._process.stopping:
            now = time.monotonic()
            if now >= next_look:
                next_look = now + _LOOK_S
                self._look()
            looked_at = self._page.has_viewers()
            opener.look(looked_at)
            self._topics.take(now)
            if looked_at:
                self._scene.update(now)
            else:
                self._scene.drawing.remember(now)
            period = _FRAME_S if looked_at else _IDLE_S
            time.sleep(max(0.0, now + period - time.monotonic()))

    def _look(self) -> None:
        self._topics.look()
        self._law.look()
        if self._commands and self._page.has_viewers():
            self._commands.prepare()
        # The pause node of an experiment repeats its state itself.
        if self._commands and not self._state.real:
            self._commands.follow_listeners(self._state.states.wished)

    def _actions(self) -> Actions | None:
        if not self._commands:
            return None
        start = self._start if self._may_start else None
        return Actions(self._commands.pause, self._reset, self._commands.stop, start)

    def _start(self, browser: int | None) -> None:
        # Over a topic, anybody could.
        made = time_since_boot() if self._browsers.is_prompt(browser) else UNKNOWN
        self._process.launcher.report(OperatorRequest(Action.START, made=made))

    def _reset(self) -> None:
        assert self._commands
        self._commands.reset()
        self._scene.drawing.clear_trails()


def main(argv: list[str] | None = None) -> int:
    """Show the fleet; returns the exit status."""
    parser = argparse.ArgumentParser(prog='browser_view', description=__doc__)
    BrowserOptions.add_to(parser)
    return node_main(parser, _show, argv)


def _show(process: RosProcess, args: argparse.Namespace) -> None:
    options = BrowserOptions.of(args)
    page = Page(options.host, options.port, needs_token=options.needs_token)
    try:
        announce(page, options)
        BrowserView(process, page, options).run()
    finally:
        page.stop()


if __name__ == '__main__':
    sys.exit(main())
