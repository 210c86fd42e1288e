"""Token of the page: who has its whole address may see it and press its buttons."""

from __future__ import annotations

import secrets
from http.cookies import CookieError, SimpleCookie
from urllib.parse import parse_qs, urlsplit


class Token:
    """A secret in the address of the page, which the browser then keeps as a cookie.

    The page itself cannot pass it on: viser opens its websocket without the query of the address.

    Attributes:
        query: What the address of the page ends in.
        cookie: The header that lets a browser keep the token.
    """

    def __init__(self, port: int) -> None:
        """Make one for a page at a port: cookies are those of a host, whatever its port."""
        self._value = secrets.token_urlsafe()
        self._name = f'setcmas_{port}'
        self.query = f'/?token={self._value}'
        self.cookie = f'{self._name}={self._value}; HttpOnly; SameSite=Strict; Path=/'

    def is_in_address(self, path: str) -> bool:
        """Return whether it is in the path of a request, with its query."""
        return any(map(self._is, parse_qs(urlsplit(path).query).get('token', [])))

    def is_kept(self, cookies: str) -> bool:
        """Return whether it is in the Cookie header of a request."""
        try:
            kept = SimpleCookie(cookies).get(self._name)
        except CookieError:
            return False
        return kept is not None and self._is(kept.value)

    def _is(self, text: str) -> bool:
        return secrets.compare_digest(text.encode(), self._value.encode())
