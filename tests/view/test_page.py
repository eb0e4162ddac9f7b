"""The page in a real browser: what a person does, and what a page must not do."""

from __future__ import annotations

import re
from collections.abc import Iterator
from importlib.resources import files
from pathlib import Path
from typing import Any

import pytest
from chromium import errors, requests, show, until

import colonysim
from colonysim.trace.replay import blocked_edges, follow
from colonysim.view import write_page
from colonysim.view.page import LIVE, MODULES, STILL


@pytest.fixture
def page(browser: Any, hard: colonysim.Run, tmp_path: Path) -> Iterator[Any]:
    """The page of a run on the hard map; a test with an error on the console fails."""
    where = write_page(hard, tmp_path / "hard.html")
    show(browser, where)
    yield browser
    assert errors(browser) == []
    assert requests(browser) == [where.as_uri()]


def ask(browser: Any, script: str) -> Any:
    return browser.execute_script(f"const page = window.colonysim; {script}")


def click(browser: Any, selector: str) -> None:
    browser.find_element("css selector", selector).click()


def press(browser: Any, *keys: str) -> None:
    from selenium.webdriver import ActionChains

    ActionChains(browser).send_keys(*keys).perform()


def text(browser: Any, selector: str) -> str:
    return str(browser.find_element("css selector", selector).text)


def seconds(browser: Any) -> float:
    return float(text(browser, "#clock").split()[0])


def picture(browser: Any, canvas: str) -> str:
    """A canvas after its next frame."""
    browser.execute_async_script("requestAnimationFrame(() => requestAnimationFrame(arguments[0]))")
    return str(browser.execute_script(f"return document.getElementById('{canvas}').toDataURL()"))


def test_it_plays_pauses_and_goes_on_to_the_next_episode(page: Any) -> None:
    assert seconds(page) == 0.0
    before = picture(page, "things")
    click(page, "#play")
    until(lambda: seconds(page) > 0.5)
    assert picture(page, "things") != before
    ask(page, "page.seek(page.replay.duration - 1000)")
    until(lambda: ask(page, "return page.replay.episode") == 1)
    click(page, "#play")
    stood = seconds(page)
    picture(page, "things")
    assert seconds(page) == stood


def test_it_scrubs_to_any_moment(page: Any, hard: colonysim.Run) -> None:
    page.execute_script(
        "const line = document.getElementById('time'); line.value = 0.5 * line.max; "
        "line.dispatchEvent(new Event('input', { bubbles: true }))"
    )
    whole = hard.episodes[0].sim_seconds
    assert seconds(page) == pytest.approx(whole / 2, abs=0.11)
    late = max((event for event in hard.events(1) if event.time <= whole / 2), key=lambda event: event.time)
    assert f"agent {late.agent}" in text(page, "#caption")
    press(page, "\ue010")  # End
    assert seconds(page) == pytest.approx(whole, abs=0.11)
    assert "episode ends: goal" in text(page, "#caption")


def test_at_every_episodes_end_everything_is_where_the_trace_says(page: Any, hard: colonysim.Run) -> None:
    scenario = hard.scenario
    ids = scenario.topology.ids
    for i, result in enumerate(hard.episodes):
        ask(page, f"page.openEpisode({i}); page.seek(5000); page.seek(1e9)")
        ways = follow(scenario, hard.events(result.episode))
        assert [ids[node] for node in ask(page, "return [...page.replay.agentNode]")] == [
            ways.agents[agent][-1] for agent in range(len(scenario.agents))
        ]
        boxes = {box: way[-1] for box, way in ways.boxes.items()}
        assert [ids[node] for node in ask(page, "return [...page.replay.boxNode]")] == list(boxes.values())
        script = "const { run, replay } = page; return [...run.edges.a].flatMap((a, e) => "
        script += "isBlocked(run, replay, e) ? [[run.nodes.id[a], run.nodes.id[run.edges.b[e]]]] : [])"
        found = ask(page, script.replace("isBlocked", "page.isBlocked"))
        assert [tuple(edge) for edge in found] == blocked_edges(scenario, boxes)


def test_it_shows_what_the_timeline_changes(browser: Any, tmp_path: Path) -> None:
    scenario = colonysim.scenario_from_document(
        {
            "nodes": [[i, 2.0 * i, 0.0] for i in range(5)],
            "edges": [[i, i + 1] for i in range(4)],
            "agents": [0],
            "goal": 4,
            "boxes": [[2, 0.7]],
            "changes": [
                {"time": 0.5, "add_edge": [1, 3]},
                {"time": 1, "remove_edge": [3, 4]},
                {"time": 2, "add_agent": 0},
                {"time": 3, "move_goal": 3},
                {"time": 4, "add_box": {"node": 1, "height": 0.7}},
                {"time": 5, "remove_box": 0},
            ],
        }
    )
    show(browser, write_page(colonysim.run(scenario, seed=1, episodes=1, out=tmp_path / "run")))
    state = "const { replay } = page; return [[...replay.taken], replay.goal, [...replay.boxNode], [...replay.state]]"
    assert ask(browser, f"page.seek(100); {state}") == [[0, 0, 1, 0, 0], 4, [2, -1], [0, 4]]
    ask(browser, "page.seek(1e9)")
    taken, goal, boxes, agents = ask(browser, f"page.seek(1e9); {state}")
    assert (taken, goal, boxes, agents) == ([0, 0, 0, 0, 1], 3, [-1, 1], [1, 1])
    assert ask(browser, f"page.seek(100); {state}") == [[0, 0, 1, 0, 0], 4, [2, -1], [0, 4]]
    assert "the goal is 3 now" in str(ask(browser, "return document.getElementById('events').textContent"))
    assert errors(browser) == []


def test_it_shows_marks_that_are_wiped_and_agents_that_stand_still(browser: Any, tmp_path: Path) -> None:
    wipe = {"nodes": [0, 1], "fields": ["E"]}
    changes = [{"time": 3.5, "wipe": wipe}, {"time": 4, "fail": {"agents": [0], "seconds": 9}}]
    place = {"topology": {"kind": "line", "nodes": 9}, "agents": [0], "goal": 8, "changes": changes}
    run = colonysim.run(colonysim.scenario_from_document(place), seed=1, episodes=1, out=tmp_path / "run")
    show(browser, write_page(run))
    left = (
        "return [...page.run.slots.field].flatMap((field, i) => page.run.fields[field] === 'E' && "
        "!Number.isNaN(page.replay.values[i]) ? [page.run.slots.place[i]] : [])"
    )
    before = ask(browser, f"page.seek(3400); {left}")
    assert 1 in before
    assert ask(browser, f"page.seek(1e9); page.seek(3600); {left}") == [node for node in before if node > 1]
    stood = "return [...page.replay.stopped]"
    assert ask(browser, f"page.seek(8000); {stood}") == [1] and ask(browser, f"page.seek(3000); {stood}") == [0]
    assert "stands still" in str(ask(browser, "return document.getElementById('events').textContent"))
    assert errors(browser) == []


def test_it_steps_by_event_with_buttons_and_keys(page: Any) -> None:
    events = ask(page, "return page.replay.last - page.replay.first")
    ask(page, "page.seek(0)")
    at = ask(page, "return page.replay.cursor")
    press(page, "\ue014", "\ue014")  # right
    assert ask(page, "return page.replay.cursor") == at + 2
    press(page, "\ue012")  # left
    click(page, "#on")
    click(page, "#back")
    assert ask(page, "return page.replay.cursor") == at + 1
    current = page.find_element("css selector", "#events [aria-current] span").text
    assert current == text(page, "#caption")
    press(page, "\ue010")
    assert ask(page, "return page.replay.cursor") == events
    page.execute_script("document.querySelector('#events li:first-child button').click()")
    assert ask(page, "return page.replay.cursor") < events


def test_layers_show_the_four_pheromones_with_a_legend(page: Any, hard: colonysim.Run) -> None:
    ask(page, "page.openEpisode(2)")
    pictures = {picture(page, "ground")}
    for field in "DHBE":
        click(page, f'#layers [data-field="{field}"]')
        assert text(page, "#legend-name").startswith(field)
        pictures.add(picture(page, "ground"))
    assert len(pictures) == 5
    click(page, '#layers [data-field="H"]')
    hole = hard.scenario.holes[1].node
    place = ask(page, f"const {{ x, y }} = page.run.nodes; const c = page.map.camera; "
                      f"return [c.screenX(x[{hole}]), c.screenY(y[{hole}])]")  # fmt: skip
    click_at(page, *place)
    assert text(page, "#legend-name") == f"H, hole {hard.scenario.topology.ids[hole]}"
    low, high = float(text(page, "#legend-low")), float(text(page, "#legend-high"))
    values = [v for e in (1, 2, 3) for (_, key), v in hard.field("H", e).items() if key == 20]
    assert low <= min(values) and high == pytest.approx(max(values), rel=0.01)
    press(page, "1")
    assert not page.find_element("id", "legend").is_displayed()


def click_at(browser: Any, x: float, y: float) -> None:
    """Clicks a point of the picture."""
    from selenium.webdriver import ActionChains

    things = browser.find_element("id", "things")
    size = things.size
    ActionChains(browser).move_to_element_with_offset(
        things, round(x - size["width"] / 2), round(y - size["height"] / 2)
    ).click().perform()


def test_a_click_on_an_agent_shows_its_last_decision(page: Any, hard: colonysim.Run) -> None:
    ask(page, "page.seek(4000)")
    agent = ask(page, "return page.replay.state.indexOf(0)")
    script = f"const c = page.map.camera, i = {agent}; page.map.draw(0); "
    place = ask(page, script + "return [c.screenX(page.replay.agentX[i]), c.screenY(page.replay.agentY[i])]")
    click_at(page, *place)
    chosen = ask(page, "return page.agent")
    assert chosen >= 0
    decision = [
        row for row in hard.table("decisions").to_pylist()
        if row["episode"] == 1 and row["agent"] == chosen and row["time"] <= 4.0
    ][-1]  # fmt: skip
    rows = page.find_elements("css selector", "#chosen tbody tr")
    assert len(rows) == len(decision["targets"])
    best = max(range(len(rows)), key=lambda i: decision["probabilities"][i])
    assert str(decision["targets"][best]) in rows[0].text
    assert f"{round(100 * decision['probabilities'][best])} %" in rows[0].text
    press(page, "\ue00c")  # escape
    assert ask(page, "return page.agent") == -1
    number = page.find_element("id", "agent")
    number.send_keys("2\n")
    assert ask(page, "return page.agent") == 2 and ask(page, "return page.field") is None
    number.send_keys("9\n")  # there is no agent 29
    assert ask(page, "return page.agent") == -1


def test_light_and_dark_zoom_and_help(page: Any) -> None:
    light = ask(page, "return page.colours.css.paper")
    click(page, "#theme")
    assert ask(page, "return page.colours.css.paper") != light
    scale = ask(page, "return page.map.camera.scale")
    click(page, '[data-zoom="in"]')
    assert ask(page, "return page.map.camera.scale") > scale
    click(page, '[data-zoom="fit"]')
    assert ask(page, "return page.map.camera.scale") == scale
    click(page, "#ask")
    assert "agent" in text(page, "#signs")
    click(page, "#help button")
    unnamed = "return [...document.querySelectorAll('button, select, input')].filter((e) => "
    unnamed += "!(e.getAttribute('aria-label') || e.labels?.length || e.textContent.trim())).length"
    assert page.execute_script(unnamed) == 0


def test_on_a_phone_nothing_is_wider_than_the_screen(page: Any) -> None:
    page.execute_cdp_cmd(
        "Emulation.setDeviceMetricsOverride", {"width": 360, "height": 740, "deviceScaleFactor": 2, "mobile": True}
    )
    try:
        until(lambda: page.execute_script("return innerWidth") == 360)
        assert page.execute_script("return document.documentElement.scrollWidth") <= 360
        assert page.execute_script("return document.getElementById('things').clientHeight") > 250
    finally:
        page.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


@pytest.mark.parametrize("last", [STILL, LIVE])
def test_the_modules_have_no_name_in_common(last: tuple[str, ...]) -> None:
    """They are joined to one program: two of one name would be an error of the whole page, not of one module."""
    defined: dict[str, str] = {}
    for module in (*MODULES, *last):
        text = files("colonysim.view").joinpath("assets", f"{module}.js").read_text(encoding="utf-8")
        for name in re.findall(r"^(?:export )?(?:async )?(?:const|let|class|function) (\w+)", text, re.MULTILINE):
            assert name not in defined, f"{name} of {module} is one of {defined[name]} too"
            defined[name] = module


def test_markup_in_a_name_is_text(browser: Any, tmp_path: Path) -> None:
    name = "</script><img src=x onerror=\"document.title='hacked'\">"
    document = dict(colonysim.load_scenario("sanity").document)
    document |= {"name": name, "description": "<b id=bold>bold</b> {{style}}"}
    run = colonysim.run(colonysim.scenario_from_document(document), seed=1, episodes=1, out=tmp_path / "run")
    where = write_page(run, tmp_path / "page.html")
    show(browser, where)
    assert text(browser, "#name") == name
    assert browser.title == f"{name} · colonysim"
    assert "<b id=bold>" in text(browser, "#what")
    assert browser.execute_script("return document.images.length + document.querySelectorAll('#bold').length") == 0
    assert errors(browser) == [] and requests(browser) == [where.as_uri()]


def test_rigid_bodies_are_shown_in_3d_where_they_were(browser: Any, engine: str, tmp_path: Path) -> None:
    run = colonysim.run("sanity", backend=engine, seed=10, episodes=1, out=tmp_path / "run")
    where = write_page(run, tmp_path / "page.html")
    show(browser, where)
    poses = [row for row in run.table("poses").to_pylist() if row["body"] == "agent" and row["number"] == 0]
    middle = poses[len(poses) // 2]
    ask(browser, f"page.seek({1000 * middle['time']}); page.replay.poseOf(0)")
    found = ask(browser, "return [...page.replay.pose]")
    assert found[:3] == pytest.approx([middle["x"], middle["y"], middle["z"]], abs=0.005)
    click(browser, '[data-view="solid"]')
    # Read in the same task as it was drawn, before the browser takes the picture away.
    count = """
        page.scene.draw(page.map.clear());
        const gl = page.scene.solids.gl, pixels = new Uint8Array(4 * gl.drawingBufferWidth * gl.drawingBufferHeight);
        gl.readPixels(0, 0, gl.drawingBufferWidth, gl.drawingBufferHeight, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
        return new Set(new Uint32Array(pixels.buffer)).size;
    """
    assert ask(browser, count) > 50
    robot = ask(browser, "return page.scene.shown.find((thing) => thing.agent === 0).screen")
    click_at(browser, *robot[:2])
    assert ask(browser, "return page.agent") == 0
    click(browser, '[data-view="map"]')
    assert errors(browser) == [] and requests(browser) == [where.as_uri()]
