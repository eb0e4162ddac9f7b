"""Policies, fields and backends of third parties: by object, by place, by entry point."""

from __future__ import annotations

import subprocess
import sys
from importlib.metadata import EntryPoint

import pytest
from small_worlds import Script, line, play

import colonysim
from colonysim import load_scenario, plugins, simulate
from colonysim.backends.nodeworld import NodeWorld
from colonysim.errors import ColonysimError, MissingExtraError, PluginError, ScenarioError
from colonysim.pheromones import Exploration, Write
from colonysim.plugins import make_backend, make_policy
from colonysim.policies.policy import Choice
from colonysim.policies.presets import Colony
from colonysim.world.intents import Travel, Wait

SOURCE = '''
from colonysim.pheromones import Exploration
from colonysim.policies.policy import Choice
from colonysim.world.intents import Travel


class East:
    name = "east"

    def __init__(self, scenario):
        self.scenario = scenario

    def fields(self, world):
        return {}

    def begin(self, agent, memory):
        return None

    def decide(self, view, memory, random):
        return Choice(Travel(view.node + 1), memory)


class Footprints(Exploration):
    name = "footprints"


class Ours(Exploration):
    name = "D"


class Nested:
    Inner = East
'''


@pytest.fixture
def third_party(tmp_path, monkeypatch):
    (tmp_path / "third_party_colony.py").write_text(SOURCE)
    (tmp_path / "third_party_broken.py").write_text("1 / 0\n")
    (tmp_path / "third_party_extra.py").write_text(
        "from colonysim.errors import MissingExtraError\nraise MissingExtraError('pip install it')\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    yield "third_party_colony"
    for name in ("third_party_colony", "third_party_broken", "third_party_extra"):
        sys.modules.pop(name, None)


class Crumbs:
    """A field of our own: 7 wherever an agent arrives."""

    name = "crumbs"
    by_box = False

    def __init__(self, world) -> None:
        self.values: dict[int, float] = {}

    def at(self, node, key=-1):
        return self.values.get(node, 0.0)

    def keys(self, node):
        return ()

    def deposit(self, visit):
        if visit.moment == "arrive":
            self.values[visit.node] = 7.0
            return (Write(visit.node, -1, 7.0),)
        return ()

    def end_episode(self):
        pass

    def frame(self):
        return [Write(node, -1, value) for node, value in self.values.items()]

    def load(self, frame):
        self.values.update((node, value) for node, _, value in frame)


class West:
    name = "west"

    def __init__(self, scenario) -> None:
        pass

    def fields(self, world):
        return {"crumbs": Crumbs(world)}

    def begin(self, agent, memory):
        return None

    def decide(self, view, memory, random):
        return Choice(Travel(view.node - 1), memory)


def test_a_policy_by_place_by_factory_and_by_object(third_party):
    scenario = line(4, goal=3, agents=[0], policy=f"{third_party}:East")
    for policy in (None, f"{third_party}:East", f"{third_party}:Nested.Inner"):
        _, rows = play(scenario, policy=policy, episodes=1)
        assert (rows.episodes[0].ended, rows.episodes[0].steps) == ("goal", 3)
    back = line(4, goal=0, agents=[3])
    for west in (West, West(back)):
        _, rows = play(back, policy=west, episodes=1)
        assert rows.episodes[0].steps == 3
        assert [(row[2], row[4], row[6]) for row in rows.tables["deposits"]] == [("crumbs", n, 7.0) for n in (2, 1, 0)]
    assert make_policy(f"{third_party}:East", scenario).scenario is scenario


def test_a_scenario_file_names_a_third_party_s_policy(third_party):
    scenario = load_scenario("sanity", None, {"policy.name": f"{third_party}:East"})
    assert type(make_policy(None, scenario)).__name__ == "East"
    run = colonysim.run(scenario, episodes=1, trace=False)
    assert run.manifest["policy"] == "east"


def test_an_extra_field_is_carried_along(third_party):
    as_exploration = {"policy.deposit_at_start": True}
    extra = {"policy.extra_fields": [f"{third_party}:Footprints"]}
    scenario = load_scenario("sanity", None, as_exploration | extra)
    events, rows = play(scenario, episodes=2, seed=1)
    assert {row[2] for row in rows.tables["deposits"]} >= {"D", "H", "E", "footprints"}
    footprints = {f.node: f.value for f in rows.tables["frames"] if f.field == "footprints" and f.episode == 2}
    assert footprints == {f.node: f.value for f in rows.tables["frames"] if f.field == "E" and f.episode == 2}
    plain, _ = play(load_scenario("sanity", None, as_exploration), episodes=2, seed=1)
    assert events == plain, "a field nobody reads changes nothing"
    assert issubclass(plugins.load("fields", f"{third_party}:Footprints"), Exploration)


def test_unknown_names_are_answered_with_the_nearest():
    scenario = load_scenario("sanity")
    with pytest.raises(PluginError, match="no policy 'colny'; did you mean 'colony'"):
        make_policy("colny", scenario)
    with pytest.raises(PluginError, match="no backend 'nodewrld'; did you mean 'nodeworld'"):
        make_backend("nodewrld")
    with pytest.raises(PluginError, match="there are: bullet, mock, mujoco, nodeworld, physics"):
        make_backend("x")
    with pytest.raises(PluginError, match="no field 'scent'"):
        play(load_scenario("sanity", None, {"policy.extra_fields": ["scent"]}))


def test_an_extra_field_takes_no_other_field_s_place(third_party):
    for extra, name in ((["Ours"], "D"), (["Footprints", "Footprints"], "footprints")):
        scenario = load_scenario("sanity", None, {"policy.extra_fields": [f"{third_party}:{each}" for each in extra]})
        with pytest.raises(ScenarioError, match=f"policy.extra_fields.*: there is a field '{name}' already"):
            play(scenario)
    with pytest.raises(ColonysimError, match="backend 'nodeworld' does not take these options"):
        make_backend("nodeworld", {"speed": 3})


@pytest.mark.parametrize("place", [
    "no_such_module_here:East", "third_party_colony:West", "third_party_broken:East", ":East", "a:b:c", "colonysim:",
])  # fmt: skip
def test_what_cannot_be_loaded_is_one_message(third_party, place):
    with pytest.raises(PluginError) as error:
        make_policy(place, load_scenario("sanity"))
    assert place in str(error.value) and "cannot be loaded" in str(error.value)


def test_a_missing_extra_stays_what_it_is(third_party):
    with pytest.raises(MissingExtraError, match="pip install it"):
        make_backend("third_party_extra:Backend")


def test_entry_points_are_found_and_cannot_shadow_ours(third_party, monkeypatch):
    points = [
        EntryPoint("east", f"{third_party}:East", "colonysim.policies"),
        EntryPoint("colony", f"{third_party}:East", "colonysim.policies"),
        EntryPoint("broken", "third_party_broken:East", "colonysim.policies"),
    ]
    monkeypatch.setattr(plugins, "entry_points", lambda group: points if group == "colonysim.policies" else [])
    scenario = load_scenario("sanity")
    assert make_policy("east", scenario).name == "east"
    assert make_policy("colony", scenario).name == "colony"
    assert "broken" in plugins.available("policies")
    with pytest.raises(PluginError, match="ZeroDivisionError"):
        make_policy("broken", scenario)
    play(scenario, policy="east", episodes=1)


def test_a_broken_plugin_does_not_break_the_import(tmp_path):
    """An installed distribution whose entry points lead to a module that raises."""
    info = tmp_path / "broken_plugin-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: broken-plugin\nVersion: 1.0\n")
    points = [f"[colonysim.{g}]\nbroken = third_party_broken:It\n" for g in ("policies", "fields", "backends")]
    (info / "entry_points.txt").write_text("".join(points))
    (tmp_path / "third_party_broken.py").write_text("raise RuntimeError('broken on purpose')\n")
    program = (
        f"import sys; sys.path.insert(0, {str(tmp_path)!r})\n"
        "import colonysim, colonysim.plugins as p\n"
        "assert all('broken' in p.available(g) for g in ('policies', 'fields', 'backends'))\n"
        "print(colonysim.run('sanity', episodes=1, trace=False).episodes[0].ended)\n"
        "try: p.load('policies', 'broken')\n"
        "except colonysim.PluginError as error: print(error)\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[0] in ("goal", "max_steps")
    assert "broken on purpose" in done.stdout


class BoardError(Exception):
    """One that cannot be built anew from its `args`."""

    def __init__(self, board, *, code) -> None:
        super().__init__(f"board {board}: code {code}")
        self.code = code


@pytest.mark.parametrize("mode", ["asynchronous", "synchronous"])
@pytest.mark.parametrize("where", ["decide", "start", "advance"])
def test_an_exception_of_a_third_party_is_one_error_that_says_whose_it_is_and_holds_it(mode, where):
    raised = BoardError(3, code=7)

    def fail(*_):
        raise raised

    class Body(NodeWorld):
        pass

    class Rule(Colony):
        pass

    body, policy = Body(), Rule(line(3, agents=(2,)))
    if where == "advance":
        body.tick = 0.5
        body.start = lambda *_: None
    setattr(policy if where == "decide" else body, where, fail)
    with pytest.raises(PluginError, match=f"{where} raises BoardError: board 3: code 7") as caught:
        list(simulate(line(3, agents=(2,)), policy=policy, backend=body, mode=mode))
    assert caught.value.__cause__ is raised and raised.__cause__ is None
    assert str(caught.value).startswith("policy 'colony', agent 0 at" if where == "decide" else "backend 'nodeworld'")


@pytest.mark.parametrize("mode", ["asynchronous", "synchronous"])
def test_a_backend_is_asked_once_what_a_move_needs_even_if_it_is_refused(mode):
    asked = []

    class Body(NodeWorld):
        def footprint(self, agent, intent):
            asked.append(agent)
            return super().footprint(agent, intent)

    def act(agent, view, n):
        return Travel(1 if agent == 0 else 0) if n == 0 else Wait((0,), 1e6)

    # Each wants to where the other stands, and is refused.
    scenario = line(3, agents=(0, 1), goal=2, max_steps=1)
    list(simulate(scenario, policy=Script(act), backend=Body(), mode=mode, episodes=1))
    assert sorted(asked) == [0, 1]


@pytest.mark.parametrize("group", ["policies", "backends", "fields"])
@pytest.mark.parametrize(
    ("made", "why"), [(None, "is None"), (3, "is no .*: int has no method"), (int, "is the class int")]
)
def test_a_factory_that_makes_no_such_part_is_refused_at_the_start(group, made, why, tmp_path, monkeypatch):
    (tmp_path / "third_party_void.py").write_text(f"def make(*_):\n    return {getattr(made, '__name__', made)}\n")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "third_party_void", raising=False)
    where = "third_party_void:make"
    scenario = line(3, agents=(2,), parameters={"extra_fields": [where]} if group == "fields" else {})
    options = {"policies": {"policy": where}, "backends": {"backend": where}, "fields": {}}[group]
    with pytest.raises(PluginError, match=f"'{where}' {why}"):
        list(simulate(scenario, **options))
    if made is not int and group != "fields":
        handed = {"policies": {"policy": lambda _: made}, "backends": {"backend": made}}[group]
        with pytest.raises(PluginError, match=f"what was given as (policy|backend) {why}"):
            list(simulate(scenario, **handed))
