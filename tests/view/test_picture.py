"""What the picture of a replay page shows, and where: labels, ground, pheromones, 3D, and the places of everything."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from chromium import errors, show, until
from test_page import ask, click, picture

import colonysim
from colonysim.view import write_page

RECORD = """
    const said = [];
    const { fillText } = CanvasRenderingContext2D.prototype;
    CanvasRenderingContext2D.prototype.fillText = function (text, x, y) {
      said.push([String(text), x, y, this.font]);
      return fillText.call(this, text, x, y);
    };
    try { DRAW } finally { CanvasRenderingContext2D.prototype.fillText = fillText; }
    return said;
"""
"""Every text that is written while something is drawn: text, x, y, font."""
ANEW = "page.map.drawnPlace = ''; page.map.draw(performance.now());"


@pytest.fixture
def page(browser: Any, hard: colonysim.Run, tmp_path: Path) -> Iterator[Any]:
    show(browser, write_page(hard, tmp_path / "hard.html"))
    yield browser
    assert errors(browser) == []


@contextmanager
def phone(browser: Any, width: int = 390, height: int = 844) -> Iterator[None]:
    metrics = {"width": width, "height": height, "deviceScaleFactor": 2, "mobile": True}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
    try:
        until(lambda: browser.execute_script("return innerWidth") == width)
        browser.execute_async_script("requestAnimationFrame(() => requestAnimationFrame(arguments[0]))")
        yield
    finally:
        browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


def grid(folder: Path, **more: Any) -> Path:
    """The page of a run on a level grid of 8 x 6 nodes."""
    place = {"topology": {"kind": "grid", "columns": 8, "rows": 6}, "agents": [0, 8], "goal": 47, "episodes": 1, **more}
    run = colonysim.run(colonysim.scenario_from_document(place), seed=3, out=folder / "run")
    return write_page(run, folder / "grid.html")


def test_labels_of_nodes_agents_and_boxes_cannot_be_taken_for_each_other(page: Any) -> None:
    ask(page, "page.openEpisode(0)")
    texts = ask(page, RECORD.replace("DRAW", ANEW))
    words = [text for text, *_ in texts if not text.endswith("%")]
    run = ask(page, "return { nodes: [...page.run.nodes.id], boxes: page.run.boxes.node.length }")
    agents = {word for word in words if word.startswith("A")}
    boxes = {word for word in words if word.startswith("B")}
    assert agents == {f"A{agent}" for agent in range(4)}
    assert boxes == {f"B{box}" for box in range(run["boxes"])}
    assert sorted(int(word) for word in words if re.fullmatch(r"\d+", word)) == sorted(run["nodes"])
    # A node's number is no sign: it stands beside the node, where an agent or a box on the node leaves it free.
    places = ask(page, "const c = page.map.camera, { id, x, y } = page.run.nodes; "
                       "return [...id].map((n, i) => [n, c.screenX(x[i]), c.screenY(y[i])])")  # fmt: skip
    radius = ask(page, "return page.map.sizes.agent")
    at = {str(number): (x, y) for number, x, y in places}
    for text, x, y, font in texts:
        if text in at:
            assert (x - at[text][0]) ** 2 + (y - at[text][1]) ** 2 > radius**2
            assert font.startswith("500 ")
        elif text in agents | boxes:
            assert font.startswith(("700 ", "bold "))


def test_on_a_phone_nothing_lies_over_the_map(page: Any) -> None:
    with phone(page):
        ask(page, "page.showField('D'); page.choose(0)")
        assert page.execute_script("return document.documentElement.scrollWidth") <= 390
        covered = """
            const { left, top, right, bottom } = document.getElementById("things").getBoundingClientRect();
            const others = [];
            for (let x = left + 2; x < right; x += 12) for (let y = top + 2; y < bottom; y += 12) {
              const found = document.elementFromPoint(x, y);
              if (found?.id !== "things") others.push([x, y, found?.outerHTML.slice(0, 60)]);
            }
            return others;
        """
        assert page.execute_script(covered) == []
        small = """
            return [...document.querySelectorAll("button")]
              .filter((each) => each.offsetParent && !each.closest("#events"))
              .map((each) => [each.id || each.textContent, each.offsetWidth, each.offsetHeight])
              .filter(([, width, height]) => width < 40 || height < 40);
        """
        assert page.execute_script(small) == []
        outside = """
            return ["play", "back", "on", "episode", "speed", "time"].filter((id) => {
              const { right, bottom } = document.getElementById(id).getBoundingClientRect();
              return right > innerWidth || bottom > innerHeight;
            });
        """
        assert page.execute_script(outside) == []


@pytest.mark.parametrize("small", [False, True])
def test_the_list_of_events_keeps_its_height_and_place_while_it_plays(page: Any, small: bool) -> None:
    def box() -> list[float]:
        script = "const r = document.getElementById('events').getBoundingClientRect(); return [r.top, r.height]"
        return list(page.execute_script(script))

    def follow() -> set[tuple[float, float]]:
        seen = set()
        for share in range(20):  # decisions with few choices and with many, pushes, waits, the goal
            ask(page, f"page.seek({share / 19} * page.replay.duration)")
            seen.add((0.0 if small else box()[0], box()[1]))
        return seen

    if small:
        with phone(page):
            ask(page, "page.choose(2)")
            assert len(follow()) == 1
    else:
        ask(page, "page.choose(2)")
        assert len(follow()) == 1
        assert box()[1] > 120
        before = box()
        ask(page, "page.choose(-1); page.showField('H')")
        assert box() == before


GROUND = """
    const { camera } = page.map, ratio = devicePixelRatio;
    const pen = document.getElementById("ground").getContext("2d");
    const at = (x, y) => pen.getImageData(camera.screenX(x) * ratio, camera.screenY(y) * ratio, 1, 1);
    return PLACES.map(([x, y]) => [...at(x, y).data]);
"""


@pytest.mark.parametrize("factor", [1.0, 0.2])
def test_the_ground_of_a_grid_is_of_one_piece(browser: Any, tmp_path: Path, factor: float) -> None:
    show(browser, grid(tmp_path))
    ask(browser, f"const c = page.map.camera; c.scale *= {factor}; c.fitted = false; c.version++; {ANEW}")
    assert ask(browser, "return page.map.far") == (factor < 1)
    within = [[column + dx, row + dy] for column in range(7) for row in range(5) for dx, dy in ((0.5, 0.5), (0.5, 0.3))]
    assert len({tuple(colour) for colour in ask(browser, GROUND.replace("PLACES", str(within)))}) == 1
    beyond = ask(browser, GROUND.replace("PLACES", "[[-0.9, 2.5]]"))[0]
    assert tuple(beyond) != tuple(ask(browser, GROUND.replace("PLACES", "[[0.5, 0.5]]"))[0])
    assert errors(browser) == []


def test_a_wall_of_a_grid_stays_a_hole_in_the_ground(browser: Any, tmp_path: Path) -> None:
    topology = {"kind": "grid", "columns": 8, "rows": 6, "without": [19]}
    show(browser, grid(tmp_path, topology=topology))
    ask(browser, ANEW)
    wall, land = ask(browser, GROUND.replace("PLACES", "[[3, 2], [5.5, 2.5]]"))
    assert wall[3] == 0 and land[3] == 255


def test_pheromones_are_heat_of_the_ground_where_agents_have_been(browser: Any, tmp_path: Path) -> None:
    show(browser, grid(tmp_path))
    ask(browser, "page.seek(2500)")
    ask(browser, ANEW)
    middles = "[[0.5, 0.5], [6.5, 4.5]]"  # between four nodes: near the start, and where nobody has been yet
    bare = ask(browser, GROUND.replace("PLACES", middles))
    click(browser, '#layers [data-field="E"]')
    picture(browser, "ground")
    near, far = ask(browser, GROUND.replace("PLACES", middles))
    assert near != bare[0] and far == bare[1]
    ask(browser, "page.seek(page.replay.duration)")
    picture(browser, "ground")
    assert ask(browser, GROUND.replace("PLACES", middles))[1] != bare[1]  # they have come to the goal
    click(browser, '#layers [data-field=""]')
    picture(browser, "ground")
    assert ask(browser, GROUND.replace("PLACES", middles)) == bare
    assert errors(browser) == []


def test_heat_has_the_colour_of_the_values_beneath(page: Any) -> None:
    ask(page, "page.openEpisode(2); page.showField('D'); page.map.heat.update(page.replay, page.layer)")
    shares = ask(page, """
        const { replay, layer, run, map: { heat } } = page, found = [];
        layer.nodes.forEach((node, i) => {
          const value = replay.values[layer.slots[i]];
          if (Number.isNaN(value)) return;
          const column = Math.round((run.nodes.x[node] - heat.bounds[0]) * heat.fine - 0.5);
          const row = Math.round((heat.bounds[3] - run.nodes.y[node]) * heat.fine - 0.5);
          const at = row * heat.columns + column;
          found.push([(value - layer.low) / (layer.high - layer.low), heat.sums[at] / heat.weights[at]]);
        });
        return found;
    """)  # fmt: skip
    assert len(shares) > 20
    assert max(abs(value - shown) for value, shown in shares) < 0.25  # neighbours weigh in
    assert sum(abs(value - shown) for value, shown in shares) / len(shares) < 0.06
    assert ask(page, "page.showField('B'); return page.map.heat.update(page.replay, page.layer)") is False


def test_3d_has_numbers_of_nodes_pins_of_agents_and_shadows(browser: Any, engine: str, tmp_path: Path) -> None:
    run = colonysim.run("sanity", backend=engine, seed=10, episodes=1, out=tmp_path / "run")
    show(browser, write_page(run, tmp_path / "page.html"))
    click(browser, '[data-view="solid"]')
    texts = ask(browser, RECORD.replace("DRAW", "page.scene.draw(page.map.clear());"))
    words = [text for text, *_ in texts]
    nodes = {str(node) for node in run.scenario.topology.ids}
    bodies = {f"A{i}" for i, _ in enumerate(run.scenario.agents)} | {f"B{i}" for i, _ in enumerate(run.scenario.boxes)}
    assert {word for word in words if word[0] in "AB"} == bodies
    numbered = {word for word in words if word.isdigit()}
    assert numbered <= nodes and len(numbered) >= len(nodes) - len(bodies)
    # On the ground beside a box: darker on the side away from the sun. Read in the same task as it was drawn.
    beside = ask(browser, """
        page.scene.draw(page.map.clear());
        const { gl } = page.scene.solids, { places, boxes } = page.run.bodies, canvas = page.scene.canvas;
        const [x, y] = places[page.run.boxes.node[0]], ground = places[page.run.boxes.node[0]][2];
        const pixel = (sign) => {
          const [length, high] = boxes[0], far = length / 2 + 0.35 * high;
          const place = page.scene.project([x + sign * far, y, ground], canvas.clientWidth, canvas.clientHeight);
          const found = new Uint8Array(4), ratio = devicePixelRatio;
          const [px, py] = [place[0] * ratio, gl.drawingBufferHeight - place[1] * ratio];
          gl.readPixels(px, py, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, found);
          return found[0] + found[1] + found[2];
        };
        return [pixel(1), pixel(-1)];
    """)  # fmt: skip
    assert beside[0] < 0.85 * beside[1]
    assert errors(browser) == []
