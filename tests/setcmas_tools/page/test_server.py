"""The server of a page: what it answers, and every request and message that it refuses."""

import asyncio
import contextlib
import http.client
import queue
import socket
import threading

import pytest
from processes import TIMEOUT_S
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

from setcmas_tools.page.browser import BrowserOptions
from setcmas_tools.page.server import Button, PageServer, refusal

NAMES = {'localhost', 'lab-pc', 'lab-pc.local'}


@pytest.mark.parametrize(
    ('host', 'origin', 'reason'),
    [
        ('127.0.0.1:8080', 'https://evil.example', 'evil.example'),
        ('127.0.0.1:8080', 'http://127.0.0.1:8888', '8888'),  # another program's page
        ('127.0.0.1:8080', 'null', 'null'),  # a file, a frame in a sandbox
        ('127.0.0.1:8080', 'http://127.0.0.1:8080.evil.example', 'evil.example'),
        ('evil.example:8080', 'http://evil.example:8080', 'not called'),  # DNS rebinding
        ('127.0.0.1.evil.example', '', 'not called'),
        ('', '', 'not called'),
        ('[::1', '', 'not called'),
        ('127.0.0.1:8080', 'http://[::1', 'may not'),
        ('127.0.0.1:8080', '', ''),
        ('localhost:9000', 'http://localhost:9000', ''),  # a port that ssh forwards
        ('192.168.1.7:8080', 'http://192.168.1.7:8080', ''),
        ('[::1]:8080', 'http://[::1]:8080', ''),
        ('Lab-PC.local:8080', 'http://lab-pc.local:8080', ''),
    ],
)
def test_pages_of_others_are_refused_and_the_page_itself_and_programs_are_not(
    host, origin, reason
):
    refused = refusal(host, origin, NAMES)
    assert reason in refused
    assert bool(reason) == bool(refused)


class Served:
    """A page on a thread of its own, and the buttons that are pressed."""

    def __init__(self, messages=None, has_buttons=False, host='127.0.0.1'):
        self.pressed = queue.Queue()
        options = BrowserOptions(host=host, port=18990)
        on_button = self.pressed.put if has_buttons else None
        self.server = PageServer('<p>page</p>', options, messages, on_button)
        self.address, _, self.query = self.server.url.partition('/?')
        self.port = int(self.address.rpartition(':')[2])
        self._loop, self._end = asyncio.new_event_loop(), asyncio.Event()
        self._thread = threading.Thread(target=self._loop.run_until_complete, args=[self._serve()])
        self._thread.start()

    async def _serve(self):
        async with self.server.serving():
            await self._end.wait()

    def stop(self):
        self._loop.call_soon_threadsafe(self._end.set)
        self._thread.join()
        self._loop.close()


@pytest.fixture
def serve(request):
    """Serve a page; the server ends with the test."""

    def start(*options, **more):
        served = Served(*options, **more)
        request.addfinalizer(served.stop)
        return served

    return start


def first():
    return [{'kind': 'now', 't': 0.0}]


@pytest.fixture
def live(serve):
    return serve(first, has_buttons=True)


def get(server, path='/', **headers):
    connection = http.client.HTTPConnection('127.0.0.1', server.port, timeout=TIMEOUT_S)
    with contextlib.closing(connection):
        connection.request('GET', path, headers=headers)
        answer = connection.getresponse()
        return answer.status, answer.headers, answer.read().decode()


def talk(server, origin=None, query=''):
    return connect(f'ws://127.0.0.1:{server.port}/live{query}', origin=origin, max_size=None)


def expect_closed(connection):
    with contextlib.suppress(ConnectionClosed):
        while True:
            connection.recv(timeout=TIMEOUT_S)
    assert connection.close_code


def test_there_is_one_page_which_no_other_page_may_hold(serve):
    server = serve()
    status, headers, text = get(server)

    assert (status, text, headers['X-Frame-Options']) == (200, '<p>page</p>', 'DENY')
    for path in ('/live', '/x', '/../../etc/passwd', '/%2e%2e/etc/passwd', '//', '/page.html'):
        assert get(server, path)[0] == 404
    status, _, text = get(server, Host=f'evil.example:{server.port}')
    assert status == 403
    assert 'open it by its address' in text


def test_a_page_from_elsewhere_gets_no_websocket(live):
    with talk(live, live.address) as own:
        assert own.recv(timeout=TIMEOUT_S)
    with pytest.raises(InvalidStatus) as refused:
        talk(live, 'https://evil.example')

    assert refused.value.response.status_code == 403


def test_a_page_with_a_token_is_for_those_who_know_its_address(serve):
    server = serve(first, has_buttons=True, host='0.0.0.0')
    address, query = server.address, server.query

    assert get(server)[0] == get(server, '/?token=guessed')[0] == 403
    assert get(server, f'/?{query}')[0] == 200
    for guess in ('', '?token=guessed'):
        with pytest.raises(InvalidStatus):
            talk(server, address, guess)
    with talk(server, address, f'?{query}') as own:
        assert own.recv(timeout=TIMEOUT_S)


def test_buttons_are_passed_on(live):
    with talk(live) as page:
        for button in Button:
            page.send(button.value)
        pressed = [live.pressed.get(timeout=TIMEOUT_S) for _ in Button]

    assert pressed == [*Button]


@pytest.mark.parametrize('message', ['', 'go', 'STOP', '"stop"', 'x' * 300, b'stop', b'\xff'])
def test_any_other_message_closes_its_own_connection_only(live, message):
    with talk(live) as other, talk(live) as page:
        page.recv(timeout=TIMEOUT_S)
        page.send(message)
        expect_closed(page)
        other.send('stop')
        assert live.pressed.get(timeout=TIMEOUT_S) is Button.STOP
    assert live.pressed.empty()


def test_a_page_without_buttons_takes_none(serve):
    server = serve(first)
    with talk(server) as page:
        page.send('stop')
        expect_closed(page)

    assert server.pressed.empty()


def test_junk_and_slow_requests_do_not_keep_others_from_the_page(live):
    junk = (
        b'\x16\x03\x01' * 50,
        b'GET / HTTP/9\r\n\r\n',
        b'POST / HTTP/1.1\r\n\r\n',
        b'\0' * 9000,
    )
    with contextlib.ExitStack() as stack:
        for content in (*junk, *[b'GET / HT'] * 60):
            one = stack.enter_context(socket.create_connection(('127.0.0.1', live.port)))
            one.sendall(content)
        assert get(live)[0] == 200
