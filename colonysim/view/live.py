"""A run shown while it goes on."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from colonysim.arguments import whole
from colonysim.view.content import introduce
from colonysim.view.feed import Feed
from colonysim.view.page import page
from colonysim.view.server import Server

if TYPE_CHECKING:
    from collections.abc import Mapping
    from types import TracebackType

    from colonysim.trace.packing import Codes, Packed
    from colonysim.trace.reader import Run
    from colonysim.trace.schema import Table
    from colonysim.view.controls import Controls

__all__ = ["Live"]

_FAREWELL = 2.0
"""Seconds that an open page has to fetch the last rows."""


class Live:
    """Serves the page of a run under way; hand it to `colonysim.run` as `tap`, and `begin` as `on_start`.

    Pages come, fall behind and go as they like: the run neither waits for them nor knows of them. Only with controls,
    handed over as `attend`, can whoever looks pause the run, let it go on, and change it.

    Args:
        port: Where to listen on this machine; 0 for any that is free.
        controls: What takes commands from the page; None for a page that only shows.

    Example:
        ```python
        with Live() as live:
            print(live.address)
            colonysim.run("hard", backend="physics", tap=live, on_start=live.begin)
        ```
    """

    def __init__(self, port: int = 0, controls: Controls | None = None) -> None:
        self._controls = controls
        self._server = Server(whole("port", port, 0, 65535), controls)
        self._feed: Feed | None = None
        self.address = self._server.address

    @property
    def trouble(self) -> str:
        """Why the page no longer shows the run, if it does not; else empty."""
        return (self._feed.trouble if self._feed else "") or self._server.trouble

    def begin(self, run: Run) -> None:
        """Shows a run that is about to start, in place of the one before."""
        if self._feed is not None:
            self._feed.end()
        self._feed = Feed(run)
        block = introduce(run)
        block.head["live"] = True
        if self._controls is not None:
            self._controls.begin(run)
            block.head["panel"] = self._controls.number
        self._server.show(page(block, live=True), self._feed)

    def take(self, table: Table, columns: Mapping[str, Packed], codes: Mapping[str, Codes]) -> None:
        """Takes a table's next rows."""
        if self._feed is not None:
            self._feed.take(table, columns, codes)

    def cut(self) -> None:
        """Shows the rows so far."""
        if self._feed is not None:
            self._feed.cut()

    def end(self) -> None:
        """Tells the pages how the run ended; they go on being served."""
        if self._controls is not None:
            self._controls.end()
        if self._feed is not None:
            self._feed.end()

    def __enter__(self) -> Live:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Ends the server, once the pages that are open know how the run ended."""
        self.end()
        feed, until = self._feed, time.monotonic() + _FAREWELL
        while feed and 0 < self._server.fetched < feed.end_number and time.monotonic() < until:
            time.sleep(0.02)
        self._server.close()
