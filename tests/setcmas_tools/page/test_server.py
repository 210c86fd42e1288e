"""The server of a page: what it answers, and every request and message that it refuses."""

import contextlib
import http.client
import json
import socket

import pytest
from processes import TIMEOUT_S
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

from setcmas_tools.page.server import Button, LiveSummary, PageServer, refusal

NAMES = {'localhost', 'lab-pc', 'lab-pc.local'}


@pytest.mark.parametrize(
    ('host', 'origin', 'reason'),
    [
        ('127.0.0.1:8080', 'https://evil.example', 'evil.example'),
        ('127.0.0.1:8080', 'http://127.0.0.1:8888', '8888'),  # another program's page
        ('127.0.0.1:8080', 'null', 'null'),  # a file, a frame in a sandbox
        ('127.0.0.1:8080', 'http://127.0.0.1:8080.evil.example', 'evil.example'),
        ('evil.example:8080', 'http://evil.example:8080', 'not called'),  # DNS rebinding
        ('127.0.0.1.evil.example', None, 'not called'),
        ('', None, 'not called'),
        ('[::1', None, 'not called'),
        ('127.0.0.1:8080', 'http://[::1', 'may not'),
        ('127.0.0.1:8080', None, ''),
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


@pytest.fixture
def serve(request):
    """Serve a page; the server ends with the test."""

    def start(**options):
        server = PageServer('<p>page</p>', '127.0.0.1', 18990, **options)
        request.addfinalizer(server.stop)
        return server

    return start


@pytest.fixture
def live(serve):
    return serve(is_live=True, has_buttons=True)


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
    with talk(live, live.url) as own:
        assert own.recv(timeout=TIMEOUT_S)
    with pytest.raises(InvalidStatus) as refused:
        talk(live, 'https://evil.example')

    assert refused.value.response.status_code == 403


def test_a_page_with_a_token_is_for_those_who_know_its_address(serve):
    server = serve(is_live=True, needs_token=True)
    address, _, query = server.url.partition('/?')

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
    server = serve(is_live=True)
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


def test_a_page_that_comes_later_gets_what_it_missed(live):
    live.send([
        {'kind': 'looks', 't': 1.0, 'items': [(2, {'name': 'tb3_2'})]},
        {'kind': 'frame', 't': 1.0, 'numbers': [2], 'poses': [1, 2, 3, 4], 'put': []},
        {'kind': 'links', 't': 1.0, 'items': [('1 2', 0.5), ('2 1', 0.5)]},
        {'kind': 'links', 't': 1.1, 'items': [('2 1', None)]},
        {'kind': 'status', 'title': 'two'},
    ])  # fmt: skip
    with talk(live) as page:
        messages = json.loads(page.recv(timeout=TIMEOUT_S))

    found = {message['kind']: message for message in messages}
    assert [message['kind'] for message in messages][:2] == ['status', 'begin']
    assert found['frame']['poses'] == [1, 2, 3, 4]
    assert found['looks']['items'] == [[2, {'name': 'tb3_2'}]]
    assert found['links']['items'] == [['1 2', 0.5]]


def test_the_past_is_bounded_and_ends_with_the_run():
    summary = LiveSummary()
    for number in range(3000):
        summary.take({'kind': 'frame', 't': number / 10})
    frames = [one['t'] for one in summary.messages() if one['kind'] == 'frame']

    assert (len(frames), frames[-1]) == (LiveSummary.MOST_FRAMES, 299.9)
    summary.take({'kind': 'begin'})
    assert not [one for one in summary.messages() if one['kind'] == 'frame']
