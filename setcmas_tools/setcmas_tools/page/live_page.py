"""The process that serves the page of running robots."""

from __future__ import annotations

import argparse
import asyncio
import sys
import time

from setcmas_simu.ros.fleet_node import FleetNode
from setcmas_simu.ros.process import RosProcess, node_main
from setcmas_tools.page.browser import BrowserOptions, Opener
from setcmas_tools.page.document import document, page_content, template
from setcmas_tools.page.live_run import LiveRun, live_content
from setcmas_tools.page.live_topics import FleetCommands, LiveTopics
from setcmas_tools.page.server import Button, PageServer

_LEAST_S, _LONGEST_S = 0.07, 0.1
"""Between two pictures of a page that is open: as often as robots publish their poses."""
_SETTLE_S = 0.004
_IDLE_S = 0.5
_LOOK_S = 1.0


class LivePage:
    """Reads topics, and sends the changes to the browsers that show the page."""

    def __init__(self, process: RosProcess, options: BrowserOptions) -> None:
        """Subscribe, and find a port for the page.

        Raises:
            SetcmasError: The page cannot be served there.
        """
        self._process = process
        node = FleetNode('browser_view')
        self._run = LiveRun(time.monotonic())
        self._topics = LiveTopics(node, self._run)
        process.add(node)
        self._commands = None if options.read_only else FleetCommands(node)
        self._server = PageServer(
            live_page(has_buttons=not options.read_only),
            options,
            lambda: self._run.whole(time.monotonic()),
            self._obey if self._commands else None,
        )

    async def run(self) -> None:
        """Send messages until a signal ends the process."""
        next_look = 0.0
        async with self._server.serving():
            opener = Opener(self._server.url)
            self._process.launcher.report_ready()
            while not self._process.stopping:
                now = time.monotonic()
                if now >= next_look:
                    next_look = now + _LOOK_S
                    self._look()
                opener.look(self._server.has_viewers)
                self._topics.take(now)
                self._server.send(self._run.changes(now))
                await self._wait(now)

    async def _wait(self, now: float) -> None:
        """Wait until robots publish again, or longer where no browser shows the page."""
        if self._server.has_viewers:
            await asyncio.sleep(now + _LEAST_S - time.monotonic())
            self._topics.wait(_LONGEST_S - _LEAST_S)
            await asyncio.sleep(_SETTLE_S)  # the rest of the fleet
        else:
            await asyncio.sleep(_IDLE_S)

    def _look(self) -> None:
        self._topics.look()
        self._process.serve(0.0)
        if self._commands and self._server.has_viewers:
            self._commands.prepare()
        # The pause node of an experiment repeats its state itself.
        if self._commands and not self._run.real:
            self._commands.follow_subscribers(self._run.states.requested)

    def _obey(self, button: Button) -> None:
        if self._commands:
            self._commands.obey(button, self._run.real)


def live_page(has_buttons: bool) -> str:
    """Return the page of running robots."""
    body = template('live.html') + template('stage.html')
    return document('setcmas', body, page_content(**live_content(has_buttons)))


def main(argv: list[str] | None = None) -> int:
    """Show running robots; return the exit status."""
    parser = argparse.ArgumentParser(prog='browser_view', description=__doc__)
    BrowserOptions.add_to(parser)
    return node_main(parser, _show, argv)


def _show(process: RosProcess, args: argparse.Namespace) -> None:
    options = BrowserOptions.of(args)
    asyncio.run(LivePage(process, options).run())


if __name__ == '__main__':
    sys.exit(main())
