"""The page of a run under way, for browsers on this machine only."""

from __future__ import annotations

import hmac
import secrets
import struct
import threading
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler
from socketserver import ThreadingTCPServer
from typing import TYPE_CHECKING, Any
from urllib.parse import parse_qs, urlsplit

from colonysim.errors import ColonysimError

if TYPE_CHECKING:
    from colonysim.view.feed import Feed

__all__ = ["Server"]

HOST = "127.0.0.1"
_MOST_AT_ONCE = 64
"""Connections; one more is closed at once. Nobody but this machine's own programs can make any."""
_PATIENCE = 5.0
"""Seconds without a byte after which a connection is given up."""


class Server(ThreadingTCPServer):
    """Answers GET requests that carry the token: `/` with the page, `/rows?from=N` with the blocks from N on.

    It listens on the loopback interface, serves nothing that is not in memory, and takes nothing from a request but
    the token and a number. A request without the token, or with a wrong one, gets 403; so does one for another host,
    which is what a foreign web site that has its name point here (DNS rebinding) would send.

    Args:
        port: Where to listen; 0 for any that is free.

    Raises:
        ColonysimError: The port is taken, or not ours to take.
    """

    daemon_threads = True
    block_on_close = False
    allow_reuse_address = True
    request_queue_size = 128

    def __init__(self, port: int = 0) -> None:
        self.token = secrets.token_urlsafe(24)
        self.page = b""
        self.feed: Feed | None = None
        self.fetched = 0
        self._room = threading.BoundedSemaphore(_MOST_AT_ONCE)
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

    def process_request(self, request: Any, client_address: Any) -> None:
        """Answers in a thread of its own, if there are not too many."""
        if self._room.acquire(blocking=False):
            super().process_request(request, client_address)
        else:
            self.shutdown_request(request)

    def process_request_thread(self, request: Any, client_address: Any) -> None:
        """What that thread does."""
        try:
            super().process_request_thread(request, client_address)
        finally:
            self._room.release()

    def handle_error(self, request: Any, client_address: Any) -> None:
        """A client that goes away in the middle is none of the run's business."""

    def close(self) -> None:
        """Ends it."""
        self.shutdown()
        self.server_close()


class _Answer(BaseHTTPRequestHandler):
    """One connection."""

    server: Server
    timeout = _PATIENCE
    protocol_version = "HTTP/1.1"
    server_version, sys_version = "colonysim", ""

    def do_GET(self) -> None:
        """Answers the one method there is; the base class refuses all others."""
        try:
            url = urlsplit(self.path)
            query = parse_qs(url.query)
        except ValueError:
            self._refuse(HTTPStatus.BAD_REQUEST)
            return
        if not self.server.admits(self.headers.get_all("Host", []), query.get("token", [""])[0]):
            self._refuse(HTTPStatus.FORBIDDEN)
        elif self.server.feed is None:
            self._refuse(HTTPStatus.SERVICE_UNAVAILABLE)
        elif url.path == "/":
            self._send(self.server.page, "text/html; charset=utf-8")
        elif url.path == "/rows":
            self._send_rows(self.server.feed, query.get("from", ["0"])[0])
        else:
            self._refuse(HTTPStatus.NOT_FOUND)

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
