"""A run under way in a browser, and what nobody may do to it."""

from __future__ import annotations

import http.client
import json
import os
import pty
import random
import re
import signal
import socket
import struct
import subprocess
import sys
import threading
import time
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import pytest
from chromium import errors, requests, until
from test_page import ask, click, press, text
from typer.testing import CliRunner

import colonysim
from colonysim.cli import app
from colonysim.errors import ColonysimError
from colonysim.trace import writer
from colonysim.view import feed, server
from colonysim.view.content import gather
from colonysim.view.live import Live
from colonysim.view.packing import unpack


@pytest.fixture(autouse=True)
def _eager(monkeypatch: pytest.MonkeyPatch) -> None:
    """Rows come in as many pieces as there are steps."""
    monkeypatch.setattr(writer, "SHARE_SECONDS", 0.0)


@pytest.fixture
def live() -> Iterator[Live]:
    with Live() as page:
        yield page


def get(live: Live, path: str, host: str | None = None, method: str = "GET") -> tuple[int, bytes]:
    place = urlsplit(live.address)
    connection = http.client.HTTPConnection(place.hostname or "", place.port or 0, timeout=10)
    try:
        connection.request(method, path, headers={"Host": host or place.netloc})
        answer = connection.getresponse()
        return answer.status, answer.read()
    finally:
        connection.close()


def rows(live: Live, start: int = 0) -> list[tuple[dict[str, Any], dict[str, Any]]]:
    status, raw = get(live, f"/rows?from={start}&{urlsplit(live.address).query}")
    assert status == 200
    found, at = [], 4
    while at < len(raw):
        (size,) = struct.unpack_from("<I", raw, at)
        found.append(unpack(raw[at + 4 : at + 4 + size]))
        at += 4 + size
    return found


@pytest.mark.parametrize(
    ("record", "marks", "decided"),
    [
        ("decisions,deposits,frames", True, True),
        ("decisions,deposits,last-frames", False, True),
        ("frames", False, False),
    ],
)
def test_pheromones_that_are_not_known_at_every_moment_are_not_shown(
    live: Live, record: str, marks: bool, decided: bool
) -> None:
    colonysim.run("sanity", episodes=2, trace=False, record=record, tap=live, on_start=live.begin)
    live.end()
    told = [(head, columns) for head, columns in rows(live) if "events.time" in columns]
    assert sum(len(columns["events.time"]) for _, columns in told) > 0 and live.trouble == ""
    assert any(head["fields"] for head, _ in told) == marks
    assert any(len(columns["deposits.time"]) or len(columns["starts.slot"]) for _, columns in told) == marks
    assert any(len(columns["decisions.time"]) for _, columns in told) == decided


class Gate:
    """Lets a run in a thread of its own go on only as far as it is told."""

    def __init__(self, live: Live, **options: Any) -> None:
        self._steps, self._done = threading.Semaphore(0), threading.Semaphore(0)
        self._free = False
        self.run: colonysim.Run | None = None
        self._options = options
        self._live = live
        self._thread = threading.Thread(target=self._go, daemon=True)
        self._thread.start()

    def _go(self) -> None:
        self.run = colonysim.run(
            **self._options, tap=self._live, on_start=self._live.begin, on_event=self._on_event,
        )  # fmt: skip
        self._live.end()
        self._done.release()

    def _on_event(self, event: colonysim.Event, run: colonysim.Run) -> None:
        if not self._free:
            self._steps.acquire()
            self._done.release()

    def let(self, events: int) -> None:
        for _ in range(events):
            self._steps.release()
        for _ in range(events):
            self._done.acquire()

    def finish(self) -> colonysim.Run:
        self._free = True
        self._steps.release()
        self._thread.join(60)
        assert self.run is not None
        return self.run


def test_the_page_follows_a_run_to_its_end(browser: Any, live: Live, tmp_path: Path) -> None:
    gate = Gate(live, scenario="hard", variant="r5-4", seed=10, episodes=2, out=tmp_path / "run")
    gate.let(40)
    browser.get("about:blank")
    browser.get_log("performance"), browser.get_log("browser")
    browser.get(live.address)
    until(lambda: browser.execute_script("return Boolean(window.colonysim)"))
    until(lambda: text(browser, "#state") == "under way")
    assert ask(browser, "return page.following") and text(browser, "#name") == "hard r5-4"
    until(lambda: ask(browser, "return page.run.events.time.length") >= 30)
    before = ask(browser, "return page.replay.duration")
    gate.let(20)
    until(lambda: ask(browser, "return page.replay.duration") > before)
    to = "page.replay.duration - page.replay.longest"
    until(lambda: ask(browser, f"return page.replay.time >= {to}"))
    assert "under way" in text(browser, "#result")
    # Whoever looks back is left there, until he asks for the newest again.
    press(browser, "\ue011")  # Home
    assert not ask(browser, "return page.following")
    press(browser, "l")
    assert ask(browser, "return page.following")
    click(browser, '#layers [data-field="D"]')
    run = gate.finish()
    until(lambda: text(browser, "#state") == "the run is over: finished")
    until(lambda: ask(browser, "return page.replay.episode === 1 && page.replay.time === page.replay.duration"))
    assert ask(browser, "return page.run.hash") == run.trace_sha256
    assert not browser.find_element("id", "live").is_displayed()
    assert errors(browser) == []
    asked = {url.split("?")[0] for url in requests(browser)}
    home = live.address.split("?")[0]
    assert asked <= {home, home + "rows", home + "favicon.ico"}


def test_what_came_piece_by_piece_is_the_run(browser: Any, live: Live, tmp_path: Path) -> None:
    """The page of a run that is over and the one that followed it know the same."""
    run = colonysim.run(
        "hard", variant="r5-4", seed=11, episodes=3, out=tmp_path / "run", tap=live, on_start=live.begin,
        on_event=lambda event, _: time.sleep(0.005),
    )  # fmt: skip
    live.end()
    blocks = rows(live)
    assert len(blocks) > 4
    browser.get(live.address)
    until(lambda: browser.execute_script("return window.colonysim?.run.status === 'finished'"))
    head, columns = unpack(gather(run).compressed())
    assert ask(browser, "return page.run.episodes") == head["episodes"]
    for name, column in columns.items():
        table, _, part = name.partition(".")
        if table in ("events", "decisions", "deposits") and part not in ("kind", "action", "status", "reason", "slot"):
            assert ask(browser, f"return [...page.run.{name}]") == pytest.approx(column.tolist()), name
    for name in ("kind", "action", "status", "reason"):
        words = [head[f"words.{name}"][code] for code in columns[f"events.{name}"]]
        assert ask(browser, f"return [...page.run.events.{name}].map((c) => page.run['words.{name}'][c])") == words
    slot = "(s) => [page.run.fields[page.run.slots.field[s]], page.run.slots.place[s], page.run.slots.key[s]]"
    for table in ("starts", "deposits"):
        marks = [
            [head["fields"][columns["slots.field"][s]], int(columns["slots.place"][s]), int(columns["slots.key"][s])]
            for s in columns[f"{table}.slot"]
        ]
        assert sorted(ask(browser, f"return [...page.run.{table}.slot].map({slot})")) == sorted(marks)
    for i in range(3):  # and it arrives where the trace says
        ask(browser, f"page.openEpisode({i}); page.seek(1e9)")
        ids = run.scenario.topology.ids
        last = {event.agent: event.now_at for event in run.events(i + 1) if event.kind == "end"}
        assert [ids[node] for node in ask(browser, "return [...page.replay.agentNode]")] == [last[a] for a in range(4)]
    assert errors(browser) == []


def test_rigid_bodies_come_piece_by_piece_too(browser: Any, live: Live, engine: str, tmp_path: Path) -> None:
    run = colonysim.run(
        "sanity", backend=engine, seed=10, episodes=2, out=tmp_path / "run", tap=live, on_start=live.begin,
    )  # fmt: skip
    live.end()
    assert sum("poses.time" in columns for _, columns in rows(live)) > 2
    browser.get(live.address)
    until(lambda: browser.execute_script("return window.colonysim?.run.status === 'finished'"))
    assert browser.find_element("id", "views").is_displayed()
    _, columns = unpack(gather(run).compressed())
    assert ask(browser, "return [...page.run.poses.first]") == columns["poses.first"].tolist()
    for name in ("time", "x", "y", "z", "roll", "pitch", "yaw"):
        found = ask(browser, f"return [...page.run.poses.{name}]")
        # Angles of bodies in their first block may be whole turns off.
        off = {round((a - b) / 6283.185) * 6283.185 for a, b in zip(found, columns[f"poses.{name}"], strict=True)}
        assert len(off) == 1 or name == "yaw"
        if name in ("time", "x", "y", "z"):
            assert found == columns[f"poses.{name}"].tolist()
    click(browser, '[data-view="solid"]')
    assert errors(browser) == []


def test_without_the_token_there_is_nothing(live: Live) -> None:
    colonysim.run("sanity", seed=10, episodes=1, trace=False, tap=live, on_start=live.begin)
    query = urlsplit(live.address).query
    token = query.partition("=")[2]
    port = urlsplit(live.address).port
    for path in ("/", "/rows?from=0", "/?token=", "/?token=x", f"/?token={token[:-1]}", f"/?token={token}x",
                 f"/rows?from=0&token={token.swapcase()}", "/?token=%ff%00", f"/?x={token}", f"/{token}"):  # fmt: skip
        assert get(live, path) == (403, b"403 Forbidden\n"), path
    assert get(live, f"/?{query}")[0] == get(live, f"/rows?{query}")[0] == 200
    with Live() as other:
        assert other.address.partition("=")[2] != token and len(token) >= 32
    # A site elsewhere whose name was made to point here would know no token; it would be sent away even with one.
    for host in ("evil.example", f"evil.example:{port}", "127.0.0.1", f"127.0.0.1:{port + 1}", f"[::1]:{port}", ""):
        assert get(live, f"/?{query}", host=host or " ")[0] == 403, host
    assert get(live, f"/?{query}", host=f"localhost:{port}")[0] == 200
    for method in ("POST", "PUT", "DELETE", "HEAD", "OPTIONS", "PATCH", "TRACE", "CONNECT"):
        assert get(live, f"/?{query}", method=method)[0] == 501
    for path in ("/../manifest.json", "/etc/passwd", "/view.html", "/rows/"):
        assert get(live, f"{path}?{query}")[0] == 404, path
    for number in ("-1", "x", "1e9", "9" * 30, "\N{ARABIC-INDIC DIGIT ONE}".encode().hex()):
        assert get(live, f"/rows?from={number}&{query}")[0] == 400, number


def test_it_listens_to_this_machine_only(live: Live) -> None:
    place = urlsplit(live.address)
    assert place.hostname == "127.0.0.1"
    listening = {
        line.split()[1] for line in Path("/proc/net/tcp").read_text().splitlines()[1:]
        if line.split()[3] == "0A" and int(line.split()[1].split(":")[1], 16) == place.port
    } if Path("/proc/net/tcp").exists() else {f"0100007F:{place.port or 0:04X}"}  # fmt: skip
    assert listening == {f"0100007F:{place.port:04X}"}
    others = {info[4][0] for info in socket.getaddrinfo(socket.gethostname(), None, socket.AF_INET)} - {"127.0.0.1"}
    for other in others:
        if not other.startswith("127."):
            with pytest.raises(OSError, match=""):
                socket.create_connection((other, place.port), timeout=2)
    with pytest.raises(ColonysimError, match="cannot listen"):
        Live(place.port or 0)


def malformed(chance: random.Random, query: str, host: str) -> bytes:
    """A request that should not be."""
    noise = chance.randbytes(chance.randrange(1, 2000))
    path = chance.choice(["/", "/rows?from=0", "/../../etc/passwd", "/%2e%2e/%00", "//", "\\..\\", "*", "http://x/"])
    return chance.choice([
        b"", b"\r\n", b"\n\n\n", b"GET", b"GET /", b"GET / HTTP/9.9\r\n\r\n", b"GET / HTTP/1.1\r\n\r\n", noise,
        noise + b"\r\n\r\n", b"\x16\x03\x01" + noise, b"GET /" + b"a" * 70_000 + b" HTTP/1.1\r\n\r\n",
        b"GET / HTTP/1.1\r\n" + b"X: y\r\n" * 200 + b"\r\n", b"GET / HTTP/1.1\r\nX: " + b"y" * 70_000 + b"\r\n\r\n",
        f"{chance.choice(['POST', 'BREW', 'get', 'PRI *', 'GETT'])} {path}?{query} HTTP/1.1\r\nHost: {host}\r\n"
        "Content-Length: 1000000000\r\n\r\n".encode() + noise,
        f"GET {path} HTTP/1.1\r\nHost: {host}\r\n\r\n".encode(),
        f"GET {path}?{query} HTTP/1.1\r\nHost: {host}\r\nHost: evil.example\r\n\r\n".encode(),
        f"GET /rows?from={chance.choice(['-1', 'NaN', '99999999999', '0;rm', '%00'])}&{query} HTTP/1.1\r\n"
        f"Host: {host}\r\n\r\n".encode(),
        f"GET /rows?from=0&{query} HTTP/1.1\r\nHost: {host}\r\n".encode(),  # half of one that is fine
        f"GET /rows?from=0&{query} HTTP/1.1\r\nHost: {host}\r\n\r\n".encode(),  # and one whose answer nobody reads
    ])  # fmt: skip


def test_a_thousand_malformed_requests_change_nothing(live: Live, tmp_path: Path, capfd: Any) -> None:
    plain = colonysim.run("hard", seed=10, episodes=3, trace=False)
    place = urlsplit(live.address)
    chance = random.Random(7)
    over, sent, open_ones = threading.Event(), [0], []

    def disturb() -> None:
        while sent[0] < 1000:
            with_it = socket.create_connection((place.hostname, place.port), timeout=5)
            try:
                with_it.sendall(malformed(chance, place.query, place.netloc))
                if chance.random() < 0.3:
                    with_it.settimeout(0.02)
                    with_it.recv(chance.randrange(1, 4096))
            except OSError:
                pass  # the server has hung up on us, and rightly
            sent[0] += 1
            if chance.random() < 0.1:
                open_ones.append(with_it)  # half a request, and then silence
            else:
                with_it.close()
        over.set()

    def wait(event: colonysim.Event, run: colonysim.Run) -> None:
        if not over.is_set():
            time.sleep(0.01)
        if run.episodes and len(run.episodes) == 2:
            over.wait(120)  # the last episode begins after the last of them at the latest

    threading.Thread(target=disturb, daemon=True).start()
    run = colonysim.run("hard", seed=10, episodes=3, out=tmp_path / "run", tap=live, on_start=live.begin, on_event=wait)
    live.end()
    assert sent[0] == 1000
    assert run.trace_sha256 == plain.trace_sha256 and run.verify()
    for left in open_ones:
        left.close()
    until(lambda: get(live, f"/?{place.query}")[0] == 200)
    assert sum(len(columns.get("events.time", ())) for _, columns in rows(live)) == run.table("events").num_rows
    assert "Traceback" not in "".join(capfd.readouterr())
    assert live.trouble == ""


def test_strangers_who_keep_connections_open_shut_nobody_out(live: Live) -> None:
    """They connect and send nothing, or a byte now and then, and come back as soon as they are sent away."""
    colonysim.run("sanity", seed=10, episodes=1, trace=False, tap=live, on_start=live.begin)
    place = urlsplit(live.address)
    over = threading.Event()

    def linger(number: int) -> None:
        while not over.is_set():
            with socket.create_connection((place.hostname, place.port), timeout=10) as slow:
                try:
                    for byte in f"GET /?{place.query[:-1]} HTTP/1.1\r\nX: {'y' * 500}".encode():
                        if over.wait(0.1):
                            return
                        if number % 2:
                            slow.sendall(bytes([byte]))
                except OSError:
                    continue  # sent away

    crowd = [threading.Thread(target=linger, args=(number,), daemon=True) for number in range(100)]
    for one in crowd:
        one.start()
    time.sleep(0.5)
    for _ in range(30):
        begun = time.monotonic()
        assert get(live, f"/?{place.query}")[0] == 200
        assert get(live, f"/rows?from=0&{place.query}")[0] == 200
        assert time.monotonic() - begun < 5.0
        time.sleep(0.05)
    answering = [thread for thread in threading.enumerate() if "process_request_thread" in thread.name]
    assert len(answering) < 100
    over.set()


def test_a_request_has_to_come_in_quickly(live: Live, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(server, "_HURRY", 0.3)
    place = urlsplit(live.address)
    with socket.create_connection((place.hostname, place.port), timeout=10) as slow:
        begun = time.monotonic()
        with pytest.raises(OSError, match=r".+"):
            while time.monotonic() - begun < 10.0:
                slow.sendall(b"G")
                time.sleep(0.05)
        assert time.monotonic() - begun < 5.0


def test_a_page_that_cannot_go_on_says_so_and_the_run_goes_on(
    browser: Any, live: Live, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    real = feed.add_rows

    def fail_later(block: Any, scenario: Any, table: Any, episodes: list[int], *rest: Any) -> None:
        if episodes[0] > 1:
            raise KeyError("something that nobody thought of")
        real(block, scenario, table, episodes, *rest)

    monkeypatch.setattr(feed, "add_rows", fail_later)
    run = colonysim.run(
        "hard", seed=10, episodes=3, out=tmp_path / "run", tap=live, on_start=live.begin,
        on_event=lambda event, _: time.sleep(0.002),
    )  # fmt: skip
    live.end()
    assert run.status == "finished" and run.verify()
    assert live.trouble == "KeyError: 'something that nobody thought of'"
    head, _ = rows(live)[-1]
    assert head["trouble"] == live.trouble
    browser.get(live.address)
    until(lambda: "cannot be shown any further: KeyError" in text(browser, "#state"))


def test_the_command_tells_of_a_page_that_could_not_go_on(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: Any) -> None:
        raise RuntimeError("no rows today")

    monkeypatch.setattr(feed, "add_rows", fail)
    done = CliRunner().invoke(app, ["run", "sanity", "-n", "1", "--no-trace", "--live", "--no-open", "--pace", "0"])
    assert done.exit_code == 1 and "Error: the run went on, but its page did not: RuntimeError: no rows" in done.output


def test_large_numbers_of_nodes_and_long_times_under_way(browser: Any, live: Live, large: Path, tmp_path: Path) -> None:
    run = colonysim.run(large, episodes=2, out=tmp_path / "run", tap=live, on_start=live.begin)
    live.end()
    browser.get(live.address)
    until(lambda: browser.execute_script("return window.colonysim?.run.status === 'finished'"))
    assert live.trouble == ""
    _, columns = unpack(gather(run).compressed())
    for name in ("events.time", "events.took", "decisions.time", "deposits.time", "nodes.id"):
        assert ask(browser, f"return [...page.run.{name}]") == columns[name].tolist(), name
    assert errors(browser) == []


def test_the_oldest_blocks_go_when_there_are_too_many(monkeypatch: pytest.MonkeyPatch, live: Live) -> None:
    monkeypatch.setattr(feed, "_MOST_BYTES", 20_000)
    monkeypatch.setattr(feed, "_PAUSE", 0.0)
    plain = colonysim.run("hard", seed=10, episodes=6, trace=False)
    run = colonysim.run(
        "hard", seed=10, episodes=6, trace=False, tap=live, on_start=live.begin,
        on_event=lambda event, _: time.sleep(0.001),
    )  # fmt: skip
    live.end()
    assert run.trace_sha256 == plain.trace_sha256
    raw = get(live, f"/rows?from=0&{urlsplit(live.address).query}")[1]
    assert len(raw) < 21_000 and struct.unpack_from("<I", raw)[0] > 0
    assert [head["status"] for head, _ in rows(live)][-1] == "finished"


def test_rows_that_nobody_packs_in_time_are_not_waited_for(monkeypatch: pytest.MonkeyPatch, live: Live) -> None:
    monkeypatch.setattr(feed, "_MOST_ROWS", 200)
    monkeypatch.setattr(feed, "_PAUSE", 60.0)  # a block at the beginning, and then none until the end
    plain = colonysim.run("hard", seed=10, episodes=2, trace=False)
    run = colonysim.run("hard", seed=10, episodes=2, trace=False, tap=live, on_start=live.begin)
    live.end()
    assert run.trace_sha256 == plain.trace_sha256
    *_, (_, late), (end, _) = rows(live)
    assert 0 < len(late["events.time"]) < 200 and end["hash"] == run.trace_sha256


def test_the_command_serves_the_page_until_ctrl_c_on_a_terminal_and_ends_with_the_run_elsewhere(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "colonysim", "run", "sanity", "-n", "2", "--seed", "10", "--json"]
    plain = json.loads(subprocess.run([*command, "--no-trace"], capture_output=True, check=True).stdout)
    live = [*command, "--live", "--no-open", "--pace", "0"]
    done = subprocess.run([*live, "--out", str(tmp_path / "one")], capture_output=True, check=True, timeout=60)
    assert json.loads(done.stdout)["trace_sha256"] == plain["trace_sha256"]
    assert b"Live at http://127.0.0.1:" in done.stderr
    here, there = pty.openpty()
    with subprocess.Popen([*live, "--no-trace"], stdout=subprocess.PIPE, stderr=there) as run:
        os.close(there)
        said = b""
        while b"until Ctrl-C" not in said:
            said += os.read(here, 4096)
        address = re.search(rb"http://\S+", said)
        assert address is not None
        with urllib.request.urlopen(address[0].decode(), timeout=10) as page:
            assert b"<title>colonysim</title>" in page.read()
        run.send_signal(signal.SIGINT)
        results = json.loads(run.communicate(timeout=30)[0])
    os.close(here)
    assert run.returncode == 0 and results["trace_sha256"] == plain["trace_sha256"]
    wrong = subprocess.run([*command, "--no-trace", "--port", "8000"], capture_output=True)
    assert wrong.returncode == 2 and b"--port: only with --live" in wrong.stderr
