"""A press on the page that was held up on its way, over a real connection."""

import asyncio
import contextlib

import pytest

pytest.importorskip('viser')
import msgspec
import viser
import websockets

from setcmas_tools.view.page.buttons import Actions, Buttons
from setcmas_tools.view.page.page import Page
from setcmas_tools.view.prompt_browsers import PromptBrowsers

CAMERA = {
    'type': 'ViewerCameraMessage', 'wxyz': (1, 0, 0, 0), 'position': (0, 0, 5), 'fov': 1.0,
    'near': 0.1, 'far': 100.0, 'image_height': 100, 'image_width': 100, 'look_at': (0, 0, 0),
    'up_direction': (0, 0, 1),
}  # fmt: skip


class Network:
    """Passes bytes on; what goes to the server waits while it is not open."""

    def __init__(self, port):
        self.open = asyncio.Event()
        self.open.set()
        self._port = port

    async def serve(self, reader, writer):
        there, onward = await asyncio.open_connection('127.0.0.1', self._port)
        await asyncio.gather(self._pass_on(reader, onward), self._pass_on(there, writer, True))

    async def _pass_on(self, reader, writer, free=False):
        with contextlib.suppress(ConnectionError):
            while data := await reader.read(65536):
                if not free:
                    await self.open.wait()
                writer.write(data)
        writer.close()


async def until(condition):
    for _ in range(3000):
        if condition():
            return
        await asyncio.sleep(0.02)
    raise TimeoutError


async def press_late(page, browsers, presses, button):
    network = Network(page.server.get_port())
    relay = await asyncio.start_server(network.serve, '127.0.0.1', 0)
    url = f'ws://127.0.0.1:{relay.sockets[0].getsockname()[1]}'
    kind = [f'viser-v{viser.__version__}']
    async with relay, websockets.connect(url, subprotocols=kind, max_size=None) as browser:

        async def press():
            message = {'type': 'GuiButtonHoldMessage', 'uuid': button, 'frequency': 10.0}
            await browser.send(msgspec.msgpack.encode(message))

        async def look():
            async for _ in browser:
                pass

        looking = asyncio.create_task(look())
        await browser.send(msgspec.msgpack.encode(CAMERA))
        await until(page.has_viewers)
        await press()
        await until(lambda: presses == [False])  # it has just come: nobody knows yet
        await until(lambda: any(map(browsers.is_prompt, page.server.get_clients())))
        network.open.clear()
        await press()
        await asyncio.sleep(1.1)
        network.open.set()
        await until(lambda: len(presses) == 2)
        await until(lambda: any(map(browsers.is_prompt, page.server.get_clients())))
        await press()
        await until(lambda: len(presses) == 3)
        looking.cancel()


def test_a_press_that_the_network_held_up_is_known_to_be_old():
    page = Page('127.0.0.1', 8765)
    try:
        browsers, presses = PromptBrowsers(page.server), []
        actions = Actions(
            pause=print,
            reset=print,
            stop=print,
            start=lambda browser: presses.append(browsers.is_prompt(browser)),
        )
        buttons = Buttons(page.server.gui, actions, 0)
        buttons.show(True, False, True, False)
        asyncio.run(press_late(page, browsers, presses, buttons._start._impl.uuid))
        assert presses == [False, False, True]
    finally:
        page.stop()
