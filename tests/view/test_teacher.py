"""The teacher's panel on the page of a run under way: what is done there happens, and is in the trace."""

from __future__ import annotations

import http.client
import json
import re
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import pytest
from chromium import errors, until
from test_page import ask, click, click_at, text

import colonysim
from colonysim.errors import ColonysimError
from colonysim.scenario.loading import load_scenario
from colonysim.trace import writer
from colonysim.view.controls import Controls
from colonysim.view.live import Live
from colonysim.view.offers import offers


@pytest.fixture(autouse=True)
def _eager(monkeypatch: pytest.MonkeyPatch) -> None:
    """Rows come in as many pieces as there are steps."""
    monkeypatch.setattr(writer, "SHARE_SECONDS", 0.0)


class Lesson:
    """A run in a thread of its own, paused from the start, with its page and controls."""

    def __init__(self, scenario: Any, **options: Any) -> None:
        self.controls = Controls(20.0)
        self.live = Live(controls=self.controls)
        self.run: colonysim.Run | None = None
        self.ended = ""
        self._scenario, self._options = scenario, options
        self._begun = threading.Event()
        self._thread = threading.Thread(target=self._go, daemon=True)
        self._thread.start()
        self._begun.wait(30)

    def _go(self) -> None:
        def starts(run: colonysim.Run) -> None:
            self.live.begin(run)
            self.controls.ask({"do": "pause"})
            self._begun.set()

        try:
            self.run = colonysim.run(
                self._scenario, **self._options, tap=self.live, attend=self.controls.attend, on_start=starts
            )
            self.live.end()
        except BaseException as error:
            self.ended = type(error).__name__
            self._begun.set()

    def finish(self) -> colonysim.Run:
        self.controls.ask({"do": "pace", "seconds": 0})
        self.controls.ask({"do": "go"})
        self._thread.join(60)
        assert self.run is not None
        return self.run

    def open(self, browser: Any) -> None:
        browser.get("about:blank")
        browser.get_log("browser")
        browser.get(self.live.address)
        until(lambda: browser.execute_script("return Boolean(window.colonysim?.teacher?.state.offers)"))
        until(lambda: ask(browser, "return page.teacher.state.paused"))


@pytest.fixture
def lesson(tmp_path: Path) -> Iterator[Lesson]:
    made = Lesson("hard", seed=3, episodes=2, out=tmp_path / "run")
    yield made
    made.controls.end()
    made.live.__exit__(None, None, None)


def slide(browser: Any, name: str, value: float) -> None:
    """Moves a slider as a hand does."""
    browser.execute_script(
        "const slider = document.querySelector(`[data-name=${arguments[0]}] input[type=range]`);"
        "slider.value = arguments[1];"
        "for (const kind of ['input', 'change']) slider.dispatchEvent(new Event(kind, { bubbles: true }));", name, value
    )  # fmt: skip


def do(browser: Any, word: str) -> None:
    click(browser, f"#teacher [data-do={word}]")


def click_node(browser: Any, node: int) -> None:
    x, y = ask(
        browser,
        f"const i = page.run.nodes.id.indexOf({node}), {{ camera }} = page.map;"
        "return [camera.screenX(page.run.nodes.x[i]), camera.screenY(page.run.nodes.y[i])]",
    )
    click_at(browser, x, y)


def click_agent(browser: Any, agent: int) -> None:
    x, y = ask(
        browser,
        f"const {{ camera }} = page.map; return [camera.screenX(page.replay.agentX[{agent}]),"
        f" camera.screenY(page.replay.agentY[{agent}])]",
    )
    click_at(browser, x, y)


def said(browser: Any, words: str) -> None:
    until(lambda: re.search(words, text(browser, "#taught")))


def test_a_slider_changes_the_running_colony_and_the_run_can_be_repeated(
    browser: Any, lesson: Lesson, tmp_path: Path
) -> None:
    lesson.open(browser)
    for _ in range(5):
        do(browser, "step")
    until(lambda: lesson.controls.state()["time"] > 0)
    slide(browser, "beta", 0.5)
    said(browser, "beta is 0.5, with the next event")
    slide(browser, "exploration_evaporation", 0.1)
    said(browser, "exploration_evaporation is 0.1")
    do(browser, "step")
    do(browser, "step")
    until(lambda: lesson.controls.state()["offers"][0]["parameters"][0]["value"] == 0.5)
    listed = "[...document.querySelectorAll('#events li')].map((item) => item.textContent)"
    until(lambda: any("by hand: beta is 0.5" in item for item in ask(browser, f"return {listed}")))
    run = lesson.finish()
    assert errors(browser) == []
    plain = colonysim.run("hard", seed=3, episodes=2, trace=False)
    assert run.trace_sha256 != plain.trace_sha256
    recorded = colonysim.Run.open(tmp_path / "run")
    assert recorded.verify()
    changes = recorded.scenario.document["changes"]
    assert [change["policy"] for change in changes] == [{"beta": 0.5}, {"exploration_evaporation": 0.1}]
    happened = [(event.time, event.step) for event in recorded.events(1) if event.kind == "change"]
    assert happened == [(change["time"], number) for number, change in enumerate(changes)]
    # From the run directory by one command, and from the scenario with its timeline.
    command = [sys.executable, "-m", "colonysim", "repeat", str(tmp_path / "run"), "-q", "--out", str(tmp_path / "two")]
    done = subprocess.run(command, capture_output=True, text=True)
    assert (done.returncode, "came out the same, 2 changes by hand" in done.stdout) == (0, True), done.stderr
    tables = [colonysim.Run.open(path).table("events") for path in (tmp_path / "run", tmp_path / "two")]
    assert tables[0].equals(tables[1])
    again = colonysim.run(recorded.scenario, seed=3, episodes=2, trace=False)
    assert again.trace_sha256 == recorded.trace_sha256


def test_a_box_is_dropped_and_a_robot_killed_by_clicks_on_the_map(browser: Any, lesson: Lesson, tmp_path: Path) -> None:
    lesson.open(browser)
    do(browser, "drop")
    click_node(browser, 3)
    said(browser, "A box comes down on 3, with the next event")
    click_node(browser, 6)
    said(browser, "a box appears on the goal, expected another node")
    do(browser, "kill")
    click_agent(browser, 2)
    said(browser, "Agent 2 fails")
    do(browser, "kill")  # no tool any more: a click chooses
    for _ in range(40):
        do(browser, "step")
    until(lambda: (ask(browser, "return page.replay.boxNode[4]") or -1) >= 0)
    assert ask(browser, "return page.run.nodes.id[page.replay.boxNode[4]]") == 3
    until(lambda: ask(browser, "return page.replay.state[2]") == 3)  # lost
    click_agent(browser, 2)
    assert ask(browser, "return page.agent") == 2
    run = lesson.finish()
    kinds = [event.action for event in run.events(1) if event.kind == "change"]
    assert sorted(kinds) == ["add_box", "fail"]
    assert [event.agent for event in run.events(1) if event.kind == "lost"] == [2]
    assert colonysim.repeat(tmp_path / "run", out=tmp_path / "two").trace_sha256 == run.trace_sha256
    until(lambda: "run is over" in text(browser, "#state"))
    assert all("409 (Conflict)" in each for each in errors(browser))  # the box on the goal


def test_pausing_stepping_and_speed_are_no_part_of_the_trace(browser: Any, lesson: Lesson) -> None:
    plain = colonysim.run("hard", seed=3, episodes=2, trace=False)
    lesson.open(browser)
    assert text(browser, "#teacher [data-do=pause]") == "Go on"
    before = lesson.controls.state()["time"]
    time.sleep(0.5)
    assert lesson.controls.state()["time"] == before
    for _ in range(5):
        rows = ask(browser, "return page.run.events.time.length")
        do(browser, "step")
        until(lambda rows=rows: ask(browser, "return page.run.events.time.length") > rows)  # type: ignore[misc]
    browser.execute_script(
        "const pace = document.getElementById('pace'); pace.value = pace.max;"
        "pace.dispatchEvent(new Event('change', { bubbles: true }))"
    )
    until(lambda: lesson.controls.state()["pace"] == 0)
    do(browser, "pause")
    until(lambda: lesson.run is not None)
    assert lesson.run is not None
    assert lesson.run.trace_sha256 == plain.trace_sha256
    assert "by_hand" not in lesson.run.manifest


def test_on_a_phone_the_panel_is_below_the_map_and_large_enough(browser: Any, lesson: Lesson) -> None:
    size = browser.get_window_size()
    try:
        browser.set_window_size(390, 844)
        lesson.open(browser)
        browser.execute_script("window.scrollTo(0, 0)")
        box = "const box = (name) => document.querySelector(name).getBoundingClientRect();"
        stage = browser.execute_script(f"{box} return box('#stage').toJSON()")
        panel = browser.execute_script(f"{box} return box('#teacher').toJSON()")
        assert panel["top"] >= stage["bottom"] - 1
        assert browser.execute_script("return document.documentElement.scrollWidth") <= 390
        heights = browser.execute_script(
            "return [...document.querySelectorAll('#teacher button, #teacher input[type=number]')]"
            ".filter((each) => each.offsetParent).map((each) => each.offsetHeight)"
        )
        assert len(heights) > 8
        assert min(heights) >= 44
        wide = browser.execute_script(
            "return [...document.querySelectorAll('#teacher *')].filter((each) => each.offsetParent)"
            ".map((each) => each.getBoundingClientRect().right)"
        )
        assert max(wide) <= 390
    finally:
        browser.set_window_size(size["width"], size["height"])


def test_a_reset_ends_the_run_and_begins_another_in_a_directory_of_its_own(browser: Any, tmp_path: Path) -> None:
    command = [
        sys.executable, "-m", "colonysim", "run", "hard", "--live", "--no-open", "--seed", "3", "-n", "2", "-q",
        "--out", str(tmp_path / "lesson"),
    ]  # fmt: skip
    with subprocess.Popen(command, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as run:
        assert run.stderr is not None
        found = re.search(r"http://\S+", run.stderr.readline())
        assert found is not None
        browser.get(found[0])
        until(lambda: browser.execute_script("return Boolean(window.colonysim?.teacher?.state.offers)"))
        slide(browser, "beta", 0.5)
        said(browser, "beta is 0.5")
        browser.execute_script("window.confirm = () => true; window.before = true")
        do(browser, "reset")
        ready = "return !window.before && Boolean(window.colonysim?.teacher?.state.offers)"
        until(lambda: browser.execute_script(ready))
        assert ask(browser, "return page.teacher.state.offers[0].parameters[0].value") == 4.0
        assert ask(browser, "return page.teacher.state.made") == []
        browser.execute_script(
            "const pace = document.getElementById('pace'); pace.value = pace.max;"
            "pace.dispatchEvent(new Event('change', { bubbles: true }))"
        )
        assert run.wait(60) == 0
    first, second = (colonysim.Run.open(tmp_path / name) for name in ("lesson", "lesson-2"))
    assert (first.status, first.manifest["by_hand"]) == ("interrupted", [0])
    assert second.status == "finished"
    assert second.trace_sha256 == colonysim.run("hard", seed=3, episodes=2, trace=False).trace_sha256
    repeat = [sys.executable, "-m", "colonysim", "repeat", str(tmp_path / "lesson"), "-q", "-o", str(tmp_path / "r")]
    done = subprocess.run(repeat, capture_output=True, text=True)
    assert (done.returncode, "all that was recorded came again" in done.stdout) == (0, True), done.stderr


# -- what nobody may do ------------------------------------------------------------------------------------------------


def post(live: Live, body: bytes, path: str = "", **headers: str | None) -> tuple[int, bytes]:
    """A command as the page sends it, but for what is said."""
    place = urlsplit(live.address)
    told: dict[str, str | None] = {
        "Host": place.netloc, "Origin": f"http://{place.netloc}", "Content-Type": "application/json",
        "Content-Length": str(len(body)),
    }  # fmt: skip
    told.update({name.replace("_", "-"): value for name, value in headers.items()})
    connection = http.client.HTTPConnection(place.hostname or "", place.port or 0, timeout=10)
    try:
        connection.putrequest("POST", path or f"/controls?{place.query}", skip_host=True, skip_accept_encoding=True)
        for name, value in told.items():
            if value is not None:
                connection.putheader(name, value)
        connection.endheaders(body)
        answer = connection.getresponse()
        return answer.status, answer.read()
    finally:
        connection.close()


@pytest.mark.parametrize(
    ("status", "body", "headers"),
    [
        (403, b'{"do": "go"}', {"path": "/controls"}),
        (403, b'{"do": "go"}', {"path": "/controls?token=guess"}),
        (403, b'{"do": "go"}', {"Origin": "http://evil.example"}),
        (403, b'{"do": "go"}', {"Origin": "null"}),
        (403, b'{"do": "go"}', {"Origin": None}),
        (403, b'{"do": "go"}', {"Host": "evil.example"}),
        (415, b'{"do": "go"}', {"Content_Type": "text/plain"}),
        (415, b'{"do": "go"}', {"Content_Type": None}),
        (411, b'{"do": "go"}', {"Content_Length": None}),
        (411, b'{"do": "go"}', {"Content_Length": "-1"}),
        (411, b"", {"Transfer_Encoding": "chunked"}),
        (413, b"x", {"Content_Length": str(2**20)}),
        (400, b"\xff\xfe", {}),
        (400, b"[" * 5000, {}),
        (400, b'["go"]', {}),
        (400, b'{"do": "pace", "seconds": NaN}', {}),
        (409, b'{"do": "fly"}', {}),
        (409, b'{"do": ["go"]}', {}),
        (409, b'{"do": "pace", "seconds": "fast"}', {}),
        (409, b'{"do": "pace", "seconds": -1}', {}),
        (409, b'{"do": "change"}', {}),
        (409, b'{"do": "change", "change": {"policy": {"bta": 2}}}', {}),
        (409, b'{"do": "change", "change": {"fail": {"agents": [99]}}}', {}),
        (409, b'{"do": "change", "change": {"add_agent": 0}}', {}),
    ],
)
def test_what_is_no_command_of_the_page_is_refused(
    lesson: Lesson, status: int, body: bytes, headers: dict[str, str | None]
) -> None:
    path = headers.get("path") or ""
    told = {name: value for name, value in headers.items() if name != "path"}
    answered, answer = post(lesson.live, body, path, **told)
    assert answered == status
    if status == 409:
        assert json.loads(answer)["error"]
        assert b"Traceback" not in answer
    assert lesson.controls.state()["paused"]
    assert lesson.live.trouble == ""
    plain = colonysim.run("hard", seed=3, episodes=2, trace=False)
    assert lesson.finish().trace_sha256 == plain.trace_sha256


def test_a_command_that_never_comes_in_whole_holds_nobody_up(lesson: Lesson) -> None:
    with pytest.raises((http.client.HTTPException, OSError)):
        post(lesson.live, b'{"do"', Content_Length="100")
    assert post(lesson.live, b'{"do": "look"}')[0] == 200


def test_a_page_without_controls_takes_no_commands() -> None:
    with Live() as live:
        colonysim.run("sanity", episodes=1, trace=False, tap=live, on_start=live.begin)
        assert post(live, b'{"do": "look"}')[0] == 501


def test_when_the_run_is_over_it_says_so(lesson: Lesson) -> None:
    lesson.finish()
    until(lambda: lesson.controls.state()["over"])
    with pytest.raises(ColonysimError, match="the run is over"):
        lesson.controls.ask({"do": "pause"})
    assert lesson.controls.ask({"do": "look"})["over"]


# -- what is offered ---------------------------------------------------------------------------------------------------


def test_what_is_offered_comes_from_the_parameters_of_the_policy() -> None:
    [offer] = offers(load_scenario("hard"), "colony")
    by_name = {each["name"]: each for each in offer["parameters"]}
    epsilon = by_name["epsilon"]
    assert (epsilon["low"], epsilon["high"], epsilon["step"], epsilon["value"]) == (0.0, 1.0, 0.01, 0.2)
    assert by_name["patience"]["null"]
    assert by_name["collision"]["words"] == ["reservation", "two_node"]
    assert not {"weights", "extra_fields", "preset", "hole_diffusion"} & by_name.keys()
    paper = offers(load_scenario("hard", None, {"policy.name": "stigmergy", "policy.preset": "paper"}), "stigmergy")
    assert next(each["value"] for each in paper[0]["parameters"] if each["name"] == "beta") == 1.0
    assert offers(load_scenario("hard"), "random")[0]["parameters"] == []
