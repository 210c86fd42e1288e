import contextlib
import http.client

import pytest
from processes import TIMEOUT_S

pytest.importorskip('viser')
import viser
import websockets.asyncio.server
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from setcmas_simu.errors import SetcmasError
from setcmas_tools.view.page import request_guard
from setcmas_tools.view.page.page import Page
from setcmas_tools.view.page.request_guard import guarded_requests, refusal

NAMES = {'localhost', 'lab-pc', 'lab-pc.local'}


@pytest.mark.parametrize(
    ('host', 'origin'),
    [
        ('127.0.0.1:8080', None),
        ('127.0.0.1:8080', 'http://127.0.0.1:8080'),
        ('localhost:9000', 'http://localhost:9000'),  # a port that ssh forwards
        ('192.168.1.7:8080', 'http://192.168.1.7:8080'),
        ('[::1]:8080', 'http://[::1]:8080'),
        ('Lab-PC.local:8080', 'http://lab-pc.local:8080'),
    ],
)
def test_the_page_itself_and_programs_are_answered(host, origin):
    assert refusal(host, origin, NAMES) == ''


@pytest.mark.parametrize(
    ('host', 'origin', 'told'),
    [
        ('127.0.0.1:8080', 'https://evil.example', 'evil.example'),
        ('127.0.0.1:8080', 'http://127.0.0.1:8888', '8888'),  # another program's page
        ('127.0.0.1:8080', 'null', 'null'),  # a file, a frame in a sandbox
        ('127.0.0.1:8080', 'http://127.0.0.1:8080.evil.example', 'evil.example'),
        ('evil.example:8080', 'http://evil.example:8080', 'not called'),  # DNS rebinding
        ('127.0.0.1.evil.example', None, 'not called'),
        ('', None, 'not called'),
        ('[::1', None, 'not called'),
    ],
)
def test_pages_of_others_are_refused(host, origin, told):
    assert told in refusal(host, origin, NAMES)


@pytest.fixture
def page():
    page = Page('127.0.0.1', 18990)
    yield page
    page.stop()


def talk(address, origin, headers=None):
    """Open a websocket as viser's page does, and return the first message."""
    url = address.replace('http', 'ws')
    kinds = [f'viser-v{viser.__version__}']
    with connect(
        url, origin=origin, subprotocols=kinds, max_size=None, additional_headers=headers
    ) as socket:
        return socket.recv(timeout=TIMEOUT_S)


def test_a_page_from_elsewhere_gets_no_websocket(page):
    assert talk(page.url, page.url)
    with pytest.raises(InvalidStatus) as refused:
        talk(page.url, 'https://evil.example')

    assert refused.value.response.status_code == 403
    assert not page.server.get_clients()


def test_a_name_that_is_not_ours_gets_a_line_of_text_instead_of_the_page(page):
    def get(host):
        connection = http.client.HTTPConnection(page.host, page.port, timeout=TIMEOUT_S)
        with contextlib.closing(connection):
            connection.request('GET', '/', headers={'Host': host})
            answer = connection.getresponse()
            return answer.status, answer.headers['X-Frame-Options'], answer.read().decode()

    status, frames, text = get(f'localhost:{page.port}')
    assert (status, frames) == (200, 'DENY')
    assert '<html' in text

    status, _, text = get(f'evil.example:{page.port}')
    assert status == 403
    assert 'open it by its address' in text


def test_a_page_with_a_token_is_shown_to_those_who_know_its_address(request):
    page = Page('127.0.0.1', 18990, needs_token=True)
    request.addfinalizer(page.stop)
    address, _, query = page.url.partition('/?')

    def get(path, **headers):
        connection = http.client.HTTPConnection(page.host, page.port, timeout=TIMEOUT_S)
        with contextlib.closing(connection):
            connection.request('GET', path, headers=headers)
            answer = connection.getresponse()
            return answer.status, answer.headers['Set-Cookie']

    assert get('/') == (403, None)
    assert get('/?token=guessed') == (403, None)
    status, cookie = get(f'/?{query}')
    assert status == 200
    kept = {'Cookie': cookie.partition(';')[0]}
    assert get('/', **kept) == (200, None)
    assert get('/', Cookie='setcmas_18990=guessed') == (403, None)
    with pytest.raises(InvalidStatus):
        talk(address, address)
    assert talk(address, address, kept)


def test_a_viser_that_starts_its_server_in_another_way_is_refused():
    serve = websockets.asyncio.server.serve
    with pytest.raises(SetcmasError, match='cannot be guarded'), guarded_requests(NAMES):
        pass

    assert websockets.asyncio.server.serve is serve


def test_the_names_of_this_machine(monkeypatch):
    monkeypatch.setattr(request_guard.socket, 'gethostname', lambda: 'Lab-PC.univ.example')

    names = request_guard.names_of_this_machine()

    assert names == {'localhost', 'lab-pc', 'lab-pc.local', 'lab-pc.univ.example'}
