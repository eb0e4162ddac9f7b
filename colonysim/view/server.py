"""The page of a run under way, for browsers on this machine only."""

from __future__ import annotations

import hmac
import io
import json
import secrets
import socket
import struct
import sys
import threading
import time
from contextlib import suppress
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler
from socketserver import ThreadingTCPServer
from typing import TYPE_CHECKING, Any, NoReturn
from urllib.parse import SplitResult, parse_qs, urlsplit

from colonysim.errors import ColonysimError

if TYPE_CHECKING:
    from colonysim.view.controls import Controls
    from colonysim.view.feed import Feed

__all__ = ["Server"]

HOST = "127.0.0.1"
_MOST_AT_ONCE = 64
"""Connections. For one more the oldest that has not shown the token is closed; if all have, the new one is."""
_HURRY, _PATIENCE = 2.0, 5.0
"""Seconds that a request may take to come in, before the token was seen on a connection and from then on."""
_MOST_BODY = 2**14
"""Bytes of a command."""


class Server(ThreadingTCPServer):
    """Answers GET requests that carry the token: `/` with the page, `/rows?from=N` with the blocks from N on.

    Where there are controls it also takes commands, by POST to `/controls`: one JSON mapping of bounded size, which a
    page of this server has sent, as the Origin header says; its answer is JSON.

    It listens on the loopback interface, serves nothing that is not in memory, and takes nothing else from a request
    but the token and a number. A request without the token, or with a wrong one, gets 403; so does one for another
    host, which is what a foreign web site that has its name point here (DNS rebinding) would send.

    Whoever does not know the token cannot keep those out who do: their requests have to come in quickly, and
    where there are too many connections theirs are the first to be closed.

    Args:
        port: Where to listen; 0 for any that is free.
        controls: Take the commands; None for a server that only shows.

    Attributes:
        trouble: What went wrong in an answer and was not the client's doing; empty if nothing did.

    Raises:
        ColonysimError: The port is taken, or not ours to take.
    """

    daemon_threads = True
    block_on_close = False
    allow_reuse_address = True
    request_queue_size = 128

    def __init__(self, port: int = 0, controls: Controls | None = None) -> None:
        self.controls = controls
        self.token = secrets.token_urlsafe(24)
        self.page = b""
        self.feed: Feed | None = None
        self.fetched = 0
        self.trouble = ""
        self._lock = threading.Lock()
        # The oldest first.
        self._strangers: dict[socket.socket, None] = {}
        self._friends: set[socket.socket] = set()
        try:
            super().__init__((HOST, port), _Answer)
        except (OSError, OverflowError) as error:
            reason = getattr(error, "strerror", None) or error
            raise ColonysimError(f"cannot listen on {HOST}:{port}: {reason}") from error
        threading.Thread(target=self.serve_forever, name="colonysim server", daemon=True).start()

    @property
    def port(self) -> int:
        """Where it listens."""
        return int(self.server_address[1])

    @property
    def address(self) -> str:
        """What to open; whoever knows it may look."""
        return f"http://{HOST}:{self.port}/?token={self.token}"

    def show(self, page: str, feed: Feed) -> None:
        """Sets what is served; before, there is nothing."""
        self.feed, self.page = feed, page.encode()

    def admits(self, hosts: list[str], token: str) -> bool:
        """Whether a request may be answered, by its Host headers and the token that it carries."""
        meant = hosts in ([f"{HOST}:{self.port}"], [f"localhost:{self.port}"])
        return hmac.compare_digest(token.encode("utf-8", "replace"), self.token.encode()) and meant

    def sent_by_its_page(self, origins: list[str]) -> bool:
        """Whether a request comes from a page of this server, by the header that browsers send with each POST."""
        return origins in ([f"http://{HOST}:{self.port}"], [f"http://localhost:{self.port}"])

    def process_request(self, request: Any, client_address: Any) -> None:
        """Answers in a thread of its own, if there are not too many."""
        with self._lock:
            full = len(self._strangers) + len(self._friends) >= _MOST_AT_ONCE
            oldest = next(iter(self._strangers), None) if full else None
            if full and oldest is None:
                self.shutdown_request(request)
                return
            if oldest is not None:
                del self._strangers[oldest]
                _hang_up(oldest)
            self._strangers[request] = None
        super().process_request(request, client_address)

    def shutdown_request(self, request: Any) -> None:
        """Ends a connection."""
        self._strangers.pop(request, None)
        self._friends.discard(request)
        super().shutdown_request(request)

    def trust(self, request: socket.socket) -> None:
        """Takes note that a connection has shown the token."""
        with self._lock:
            if request in self._strangers:
                del self._strangers[request]
                self._friends.add(request)

    def patience(self, request: socket.socket) -> float:
        """Seconds that the next request on a connection may take."""
        return _PATIENCE if request in self._friends else _HURRY

    def handle_error(self, request: Any, client_address: Any) -> None:
        """A client that goes away in the middle is none of the run's business; any other fault is kept."""
        error = sys.exception()
        if request in self._friends and not isinstance(error, OSError):
            self.trouble = f"{type(error).__name__}: {error}"

    def close(self) -> None:
        """Ends it."""
        self.shutdown()
        self.server_close()


def _no_number(word: str) -> NoReturn:
    raise ValueError(f"{word} is no finite number")


def _hang_up(connection: socket.socket) -> None:
    """Wakes the thread that waits for a connection, and so ends it."""
    with suppress(OSError):
        connection.shutdown(socket.SHUT_RDWR)


class _Hurried(socket.SocketIO):
    """What comes in over a connection, until it is too late."""

    def __init__(self, connection: socket.socket) -> None:
        super().__init__(connection, "r")
        self._connection = connection
        self.until = 0.0

    def readinto(self, buffer: Any) -> int | None:
        left = self.until - time.monotonic()
        if left <= 0.0:
            raise TimeoutError("the request took too long to come in")
        self._connection.settimeout(left)
        return super().readinto(buffer)


class _Answer(BaseHTTPRequestHandler):
    """One connection."""

    server: Server
    protocol_version = "HTTP/1.1"
    server_version, sys_version = "colonysim", ""

    def setup(self) -> None:
        """Reads against the clock: a byte now and then does not keep a connection open."""
        super().setup()
        self.rfile.close()
        self._incoming = _Hurried(self.connection)
        self.rfile = io.BufferedReader(self._incoming)

    def handle_one_request(self) -> None:
        """Answers the next request, if it comes in time."""
        self._incoming.until = time.monotonic() + self.server.patience(self.connection)
        super().handle_one_request()

    def do_GET(self) -> None:
        """Answers who wants to see something; the base class refuses all methods but this one and POST."""
        asked = self._admitted()
        if asked is None:
            return
        url, query = asked
        if self.server.feed is None:
            self._refuse(HTTPStatus.SERVICE_UNAVAILABLE)
        elif url.path == "/":
            self._send(self.server.page, "text/html; charset=utf-8")
        elif url.path == "/rows":
            controls = self.server.controls
            if controls is not None and query.get("run", [str(controls.number)])[0] != str(controls.number):
                self._refuse(HTTPStatus.GONE)  # by a page of a run before this one
                return
            self._send_rows(self.server.feed, query.get("from", ["0"])[0])
        else:
            self._refuse(HTTPStatus.NOT_FOUND)

    def do_POST(self) -> None:
        """Takes a command."""
        asked = self._admitted()
        if asked is None:
            return
        controls = self.server.controls
        if controls is None:
            self._refuse(HTTPStatus.NOT_IMPLEMENTED)
        elif not self.server.sent_by_its_page(self.headers.get_all("Origin", [])):
            self._refuse(HTTPStatus.FORBIDDEN)
        elif asked[0].path != "/controls":
            self._refuse(HTTPStatus.NOT_FOUND)
        elif self.headers.get_all("Content-Type", []) != ["application/json"]:
            self._refuse(HTTPStatus.UNSUPPORTED_MEDIA_TYPE)
        elif (body := self._body()) is not None:
            self._obey(controls, body)

    def _admitted(self) -> tuple[SplitResult, dict[str, list[str]]] | None:
        """What is asked for, by one who may ask; None if the request has been refused."""
        try:
            url = urlsplit(self.path)
            query = parse_qs(url.query)
        except ValueError:
            self._refuse(HTTPStatus.BAD_REQUEST)
            return None
        if not self.server.admits(self.headers.get_all("Host", []), query.get("token", [""])[0]):
            self._refuse(HTTPStatus.FORBIDDEN)
            return None
        self.server.trust(self.connection)
        return url, query

    def _body(self) -> bytes | None:
        """The body of a request; None if the request has been refused, without reading what is too long."""
        lengths = self.headers.get_all("Content-Length", [])
        sound = len(lengths) == 1 and lengths[0].isascii() and lengths[0].isdigit() and len(lengths[0]) < 10
        if "Transfer-Encoding" in self.headers or not sound:
            self._refuse(HTTPStatus.LENGTH_REQUIRED)
        elif int(lengths[0]) > _MOST_BODY:
            self._refuse(HTTPStatus.REQUEST_ENTITY_TOO_LARGE)
        else:
            body = self.rfile.read(int(lengths[0]))
            if len(body) == int(lengths[0]):
                return body
            self._refuse(HTTPStatus.BAD_REQUEST)
        return None

    def _obey(self, controls: Controls, body: bytes) -> None:
        """Does what a command says; what cannot be is told in the answer's "error"."""
        try:
            command = json.loads(body.decode(), parse_constant=_no_number)
            if not isinstance(command, dict):
                raise ValueError("expected a mapping")
        except (ValueError, RecursionError):
            self._send_json({"error": "no command: expected a JSON mapping"}, HTTPStatus.BAD_REQUEST)
            return
        try:
            self._send_json(controls.ask(command))
        except ColonysimError as error:
            self._send_json({"error": str(error)}, HTTPStatus.CONFLICT)

    def _send_json(self, told: dict[str, Any], status: HTTPStatus = HTTPStatus.OK) -> None:
        self._send(json.dumps(told).encode(), "application/json", status)

    def _send_rows(self, feed: Feed, wanted: str) -> None:
        """The number of the first block, then each block after its length, little-endian."""
        if not (wanted.isascii() and wanted.isdigit() and len(wanted) < 10):
            self._refuse(HTTPStatus.BAD_REQUEST)
            return
        first, blocks = feed.after(int(wanted))
        self._send(
            struct.pack("<I", first) + b"".join(struct.pack("<I", len(block)) + block for block in blocks),
            "application/octet-stream",
        )
        self.server.fetched = max(self.server.fetched, first + len(blocks))

    def _refuse(self, status: HTTPStatus) -> None:
        self.close_connection = True
        self._send(f"{status.value} {status.phrase}\n".encode(), "text/plain; charset=utf-8", status)

    def _send(self, body: bytes, kind: str, status: HTTPStatus = HTTPStatus.OK) -> None:
        self.connection.settimeout(_PATIENCE)
        self.send_response(status)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(body)))
        for name, value in (
            ("Cache-Control", "no-store"),
            ("Content-Security-Policy", "frame-ancestors 'none'"),
            ("Cross-Origin-Resource-Policy", "same-origin"),
            ("Referrer-Policy", "no-referrer"),
            ("X-Content-Type-Options", "nosniff"),
        ):
            self.send_header(name, value)
        if self.close_connection:
            self.send_header("Connection", "close")
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, format: str, *args: Any) -> None:
        """Says nothing: the terminal belongs to the run."""
