"""Saved, loaded elsewhere and forked, a colony goes on as if nothing had happened."""

from __future__ import annotations

import io
import json
import random
import zipfile
from array import array
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
import pytest
from going_on import Parted, elsewhere

import colonysim
from colonysim import Colony, ColonysimError, Scenario
from colonysim.backends.mock import Mock
from colonysim.backends.nodeworld import NodeWorld
from colonysim.backends.physics import Physics
from colonysim.engines import PACKAGES
from colonysim.geometry.layout import lay_out
from colonysim.physics import engine_trouble
from colonysim.policies.policy import Choice
from colonysim.policies.uniform import Uniform
from colonysim.simulation.saving import TEXT, read_saved
from colonysim.states import copied
from colonysim.testing import random_document, random_scenario
from colonysim.testing.sections import add_sections
from colonysim.trace.writer import TraceWriter
from colonysim.world.intents import Outcome, Wait

if TYPE_CHECKING:
    from collections.abc import Callable

POLICIES = ("colony", "colony", "paper", "oracle", "random")
FADING = {"distance_half_life": 40.0, "box_half_life": 9.0, "hole_half_life": 30.0, "exploration_half_life": 2.0}


def any_scenario(rng: random.Random) -> Scenario:
    """A world of any kind, with steps enough for boxes to be pushed and few enough to be soon over."""
    settings: dict[str, Any] = {"max_steps": rng.randrange(5, 60)}
    if rng.random() < 0.5:
        scenario = random_scenario(rng.randrange(10**6), max_agents=5)
    else:
        scenario = colonysim.load_scenario(rng.choice(("hard", "medium", "easy", "junction")))
    if rng.random() < 0.3:
        settings |= {f"policy.{name}": value for name, value in FADING.items() if rng.random() < 0.6}
    if rng.random() < 0.2:
        settings["timing.jitter"] = 0.0
    if rng.random() < 0.2:
        settings["time_limit"] = rng.choice((3.0, 20.0))
    if rng.random() < 0.2:
        settings["policy.exploration_evaporation"] = None
    return colonysim.scenario_from_document(scenario.document, overrides=settings)


def any_document(rng: random.Random) -> Scenario:
    """A random world with a timeline, groups, faults and marks that fade and spread."""
    return colonysim.scenario_from_document(add_sections(rng, random_document(rng)))


def any_bodies(rng: random.Random) -> Scenario:
    """The same for rigid bodies, of what they can follow, soon over."""
    while True:
        document = {**random_document(rng, max_nodes=8, max_agents=3, max_holes=1), "max_steps": rng.randrange(6, 20)}
        scenario = colonysim.scenario_from_document(add_sections(rng, document, kinds=Physics.changes, bodies=True))
        with suppress(ColonysimError):
            lay_out(scenario)
            return scenario


def saved_somewhere(path: Path, rng: random.Random, scenario: Scenario, **asked: Any) -> tuple[str, str] | None:
    """Saves a colony at a random moment and goes on with it; hashes of all rows, and of those after that moment.

    None if it was over before.
    """
    sink = Parted()
    with Colony(scenario, sink=sink, **asked) as colony:
        if rng.random() < 0.3:
            colony.run_until(time=rng.uniform(0.0, 15.0))
        for _ in range(int(10 ** rng.uniform(0.0, 2.5))):
            if colony.step() is None:
                return None
        if rng.random() < 0.3:
            colony.run_until(time=colony.now + rng.uniform(0.0, 4.0))
        if colony.over:
            return None
        colony.save(path)
        sink.part()
        for _ in colony:
            pass
    return sink.hashes()


def check_anywhere(
    folder: Path, count: int, seed: int, together: int, world: Callable[[random.Random], Scenario], **asked: Any
) -> None:
    """Saves so many colonies, goes on with them in fresh processes, `together` in each, and compares the hashes."""
    rng, saved, expected = random.Random(seed), [], []
    while len(saved) < count:
        scenario = world(rng)
        ways = {
            "policy": rng.choice(POLICIES), "mode": rng.choice(("asynchronous", "asynchronous", "synchronous")),
            "seed": rng.randrange(10**6), "episodes": rng.randrange(1, 4), **asked,
        }  # fmt: skip
        if "policy" in scenario.document and ways["policy"] == "random":
            changes = [change for change in scenario.document.get("changes", ()) if "policy" not in change]
            document = {**scenario.document, "policy": {"name": "random"}, "changes": changes}
            scenario = colonysim.scenario_from_document(document)
        path = folder / f"{len(saved)}.npz"
        hashes = saved_somewhere(path, rng, scenario, **ways)
        if hashes is None:
            continue
        plain = TraceWriter(None, {})
        with Colony(scenario, sink=plain, kinds=("episode",), **ways) as colony:
            for _ in colony:
                pass
        assert plain.finish("finished") == hashes[0], (scenario.name, ways, "to be saved makes a difference")
        saved.append((str(path), {}))
        expected.append((hashes[1], scenario.name, ways))
    found = []
    for first in range(0, count, together):
        found += elsewhere(saved[first : first + together], first + 1)
    for number, ((hash_of_rest, *about), elsewhere_found) in enumerate(zip(expected, found, strict=True)):
        assert hash_of_rest == elsewhere_found, (number, about)


def bodies(engine: str) -> dict[str, Any]:
    if trouble := engine_trouble(engine):
        pytest.skip(trouble)
    return {"backend": engine, "backend_options": {"push": "scripted"}}


def physics(engine: str) -> dict[str, Any]:
    return {**bodies(engine), "policy": "colony", "scenario": sanity()}


def own(world: Any) -> dict[str, Any]:
    """What is not drawn besides the world."""
    return {"policy": "colony"} if world is sanity else {} if world is any_scenario else {"policy": None}


def sanity(rng: random.Random | None = None) -> Scenario:
    return colonysim.load_scenario("sanity", None, {"max_steps": 8})


@pytest.mark.parametrize("world", [any_scenario, any_document])
def test_loaded_in_another_process_it_goes_on_the_same(world: Any, tmp_path: Path) -> None:
    check_anywhere(tmp_path, 24, 1, 12, world, **own(world))


@pytest.mark.parametrize("world", [sanity, any_bodies])
@pytest.mark.parametrize("engine", PACKAGES)
def test_loaded_in_another_process_bodies_go_on_the_same(engine: str, world: Any, tmp_path: Path) -> None:
    check_anywhere(tmp_path, 2, 1, 2, world, **bodies(engine), **own(world))


@pytest.mark.slow
@pytest.mark.parametrize("world", [any_scenario, any_document])
def test_loaded_in_another_process_it_goes_on_the_same_500_times(world: Any, tmp_path: Path) -> None:
    check_anywhere(tmp_path, 500, 2, 10, world, **own(world))


@pytest.mark.slow
@pytest.mark.parametrize("world", [sanity, any_bodies])
@pytest.mark.parametrize(("engine", "count"), [("mujoco", 50), ("bullet", 20)])
def test_loaded_in_another_process_bodies_go_on_the_same_many_times(
    engine: str, count: int, world: Any, tmp_path: Path
) -> None:
    check_anywhere(tmp_path, count, 3, 5, world, **bodies(engine), **own(world))


def events(colony: Colony) -> list[Any]:
    return list(colony)


def test_between_two_episodes_and_before_the_first(tmp_path: Path, backend: str) -> None:
    options = {} if backend == "nodeworld" else {"push": "scripted"}
    colony = Colony("sanity", seed=3, episodes=2, backend=backend, backend_options=options)
    colony.save(tmp_path / "first.npz")
    colony.run_until(episode=1)
    colony.save(tmp_path / "second.npz")
    second = events(colony)
    assert events(Colony.load(tmp_path / "second.npz")) == second
    assert events(Colony.load(tmp_path / "first.npz"))[-len(second) :] == second


@pytest.mark.parametrize("engine", PACKAGES)
def test_bodies_at_the_very_beginning_of_a_second_episode(engine: str, tmp_path: Path) -> None:
    colony = Colony(**physics(engine), seed=3, episodes=2)
    colony.run_until(episode=1)
    colony.step()
    colony.save(tmp_path / "saved.npz")
    assert events(Colony.load(tmp_path / "saved.npz")) == events(colony)


def test_what_is_shown_is_the_same(tmp_path: Path) -> None:
    colony = Colony("hard", seed=4, policy="paper")
    colony.run_until(time=17.0)
    colony.save(tmp_path / "saved.npz")
    other = Colony.load(tmp_path / "saved.npz")
    assert repr(other) == repr(colony) and other.now == 17.0 and other._repr_html_() == colony._repr_html_()
    for name in ("node", "level", "held_box", "status", "steps", "waited"):
        assert (getattr(other.agents, name) == getattr(colony.agents, name)).all()
    for name in colony.fields:
        assert other.fields[name].items() == colony.fields[name].items()
    other.save(tmp_path / "again.npz")
    first, again = (np.load(tmp_path / name, allow_pickle=False) for name in ("saved.npz", "again.npz"))
    assert first.files == again.files
    assert [name for name in first.files if name != TEXT and (first[name] != again[name]).any()] == []


def test_a_twin_does_the_same_and_a_seed_something_else() -> None:
    colony = Colony("hard", seed=1, episodes=2)
    colony.run_until(time=12.0)
    twin, seven, again, eight = colony.fork(), colony.fork(7), colony.fork(7), colony.fork(8)
    own = events(colony)
    assert events(twin) == own
    found = events(seven)
    assert found == events(again) != own and found != events(eight)
    assert all(event.time >= 12.0 for event in found if event.episode == 1)


@pytest.mark.parametrize("count", [20, pytest.param(300, marks=pytest.mark.slow)])
def test_twins_of_worlds_with_every_section_do_the_same(count: int) -> None:
    for number in range(count):
        rng = random.Random(f"twins/{number}")
        scenario, mode = any_document(rng), rng.choice(("asynchronous", "synchronous"))
        whole = list(colonysim.simulate(scenario, seed=number, mode=mode, episodes=2))
        colony, seen, twins = Colony(scenario, seed=number, mode=mode, episodes=2), 0, []
        while colony.step() is not None:
            seen += 1
            if rng.random() < 0.05 and len(twins) < 3 and not colony.over:
                twins.append((seen, colony.fork()))
        assert seen == len(whole), number
        for since, twin in twins:
            assert events(twin) == whole[since:], number


def test_a_fork_of_the_same_seed_is_no_repetition() -> None:
    colony = Colony("hard", seed=1, episodes=2)
    colony.run_until(episode=1)
    assert events(colony.fork(1)) != events(colony)


@pytest.mark.parametrize("engine", PACKAGES)
def test_bodies_are_forked_and_saved_again(engine: str, tmp_path: Path) -> None:
    asked = physics(engine)
    colony = Colony(**asked, seed=1, episodes=1)
    colony.run_until(time=4.0)
    fork = colony.fork(5, overrides={"policy.beta": 9.0})
    fork.run_until(time=6.0)
    second = fork.fork(6)
    second.run_until(time=7.0)
    second.save(tmp_path / "saved.npz")
    rest = events(second)
    assert events(Colony.load(tmp_path / "saved.npz")) == rest and rest
    assert events(fork.fork()) == events(fork)


def test_settings_change_from_that_moment_on(tmp_path: Path) -> None:
    colony = Colony("hard", seed=1, episodes=4)
    colony.run_until(time=12.0)
    slow = colony.fork(overrides={"timing.travel": 50.0, "episodes": 1})
    assert slow.scenario.timing.travel == 50.0
    slow.save(tmp_path / "slow.npz")
    first = events(slow)
    assert events(Colony.load(tmp_path / "slow.npz")) == first and first[-1].kind == "episode"
    assert first[-1].time > events(colony)[0].time + 50.0
    forgetful = Colony("hard", seed=1)
    forgetful.run_until(time=12.0)
    marks = forgetful.fork(overrides={"policy.exploration_half_life": 1e-3})
    marks.run_until(time=13.0)
    forgetful.run_until(time=13.0)
    assert marks.fields["E"].values().sum() < 0.5 * forgetful.fields["E"].values().sum()


@pytest.mark.parametrize(("before", "after"), [(None, 5.0), (5.0, None), (5.0, 1.0)])
def test_another_half_life_counts_from_that_moment_on(before: float | None, after: float | None) -> None:
    names = ("distance", "box", "hole", "exploration")
    scenario = colonysim.load_scenario("hard", None, {f"policy.{name}_half_life": before for name in names})
    colony = Colony(scenario, seed=1, episodes=2)
    colony.run_until(time=20.0)
    fork = colony.fork(overrides={f"policy.{name}_half_life": after for name in names})
    for name, field in colony.fields.items():
        assert fork.fields[name].items() == pytest.approx(field.items(), rel=1e-9), name
    nodes = fork.fields["E"].values().max()
    fork.run_until(time=20.001)
    assert fork.fields["E"].values().max() == pytest.approx(nodes, rel=1e-2)


@pytest.mark.parametrize(
    ("overrides", "words"),
    [
        ({"policy.name": "random"}, "cannot change under way"),
        ({"agents": [2, 8]}, "cannot change under way"),
        ({"mode": "synchronous"}, "cannot change under way"),
        ({"policy.preset": "paper"}, "cannot change under way"),
        ({"policy.exploration_diffusion": 0.5}, "cannot change under way, as marks are kept by it"),
        ({"policy.diffusion_period": 2.0}, "cannot change under way, as marks are kept by it"),
        ({"time_limit": 12.0}, "time_limit=12: the episode under way is at 12 s, expected more than that"),
        ({"policy.betta": 1}, "did you mean 'beta'"),
        ({"policy.extra_fields": ["nothing:Here"]}, "nothing"),
    ],
)
def test_what_cannot_change(overrides: dict[str, Any], words: str) -> None:
    colony = Colony("hard", seed=1)
    colony.run_until(time=12.0)
    with pytest.raises(ColonysimError, match=words):
        colony.fork(overrides=overrides)
    assert events(colony), "the colony itself goes on"


def test_measurements_go_on_where_they_were(tmp_path: Path) -> None:
    def measured(colony: Colony) -> Colony:
        colony.measure("here", lambda held: float(held.agents.node.sum()), every=2.5)
        return colony

    whole = measured(Colony("hard", seed=1, episodes=2))
    events(whole)
    for time in (5.0, 5.001, 0.0, 24.9):
        colony = measured(Colony("hard", seed=1, episodes=2))
        colony.run_until(time=time)
        colony.save(tmp_path / "saved.npz")
        other = measured(Colony.load(tmp_path / "saved.npz"))
        events(other)
        assert other.measurements == whole.measurements
    colony = Colony("hard", seed=1)
    colony.measure("here", lambda held: 0.0, every=2.5)
    colony.run_until(time=4.0)
    colony.save(tmp_path / "saved.npz")
    other = Colony.load(tmp_path / "saved.npz")
    for every in (1.0, None):
        with pytest.raises(ColonysimError, match=r"'here' was measured every 2\.5 s when the colony was saved"):
            other.measure("here", lambda held: 0.0, every=every)
    colony = Colony("hard", seed=1)
    colony.measure("saves", lambda held: held.save(tmp_path / "no.npz"))  # type: ignore[arg-type, return-value]
    with pytest.raises(ColonysimError, match="in the middle of a measurement"):
        events(colony)


def test_an_observer_may_save(tmp_path: Path) -> None:
    colony, rest = Colony("hard", seed=1, episodes=1), []
    end = colony.on("goal", lambda event, held: held.save(tmp_path / "saved.npz"))
    colony.run_until(event="goal")
    end()
    rest = events(colony)
    assert events(Colony.load(tmp_path / "saved.npz")) == rest


def test_a_colony_that_is_over_has_no_future(tmp_path: Path) -> None:
    colony = Colony("sanity", episodes=1)
    events(colony)
    for call in (lambda: colony.save(tmp_path / "saved.npz"), colony.fork):
        with pytest.raises(ColonysimError, match="no future to save"):
            call()


# -- parts of others ---------------------------------------------------------------------------------------------------


class Counting(Uniform):
    """Remembers whatever it is told to."""

    name = "counting"
    remembers: ClassVar[Any] = {"seen": {3: (1, 2.5)}, "some": array("d", [1.0]), "numbers": np.arange(3), "b": b"x"}

    def begin(self, agent: int, memory: Any) -> Any:
        return memory or (0, self.remembers)

    def decide(self, view: Any, memory: Any, random: random.Random) -> Choice:
        assert memory[1].keys() == self.remembers.keys() and memory[1]["seen"] == {3: (1, 2.5)}
        random.gauss(0.0, 1.0)
        return super().decide(view, (memory[0] + 1, memory[1]), random)._replace(memory=(memory[0] + 1, memory[1]))


class Secretive(Counting):
    """Remembers what is no plain data, and says how to write it down."""

    def begin(self, agent: int, memory: Any) -> Any:
        return memory or {agent}

    def decide(self, view: Any, memory: Any, random: random.Random) -> Choice:
        return Uniform.decide(self, view, None, random)._replace(memory=memory | {view.node})

    def state(self, agent: int, memory: Any) -> Any:
        return sorted(memory)

    def restore(self, agent: int, state: Any) -> Any:
        return set(state)


class Mute(Secretive):
    """The same without saying how."""

    state = restore = None  # type: ignore[assignment]


@pytest.mark.parametrize("policy", [Counting, Secretive])
def test_policies_of_others_take_part(policy: Any, tmp_path: Path) -> None:
    colony = Colony("hard", seed=2, episodes=2, policy=policy)
    colony.run_until(time=9.0)
    colony.save(tmp_path / "saved.npz")
    twin, rest = colony.fork(), events(colony)
    assert events(twin) == rest == events(Colony.load(tmp_path / "saved.npz", policy=policy))
    with pytest.raises(ColonysimError, match=r"saved\.npz: its policy '.*' was given as an object"):
        Colony.load(tmp_path / "saved.npz")


def test_a_memory_that_is_no_plain_data_is_refused(tmp_path: Path) -> None:
    colony = Colony("hard", seed=2, policy=Mute)
    colony.run_until(time=9.0)
    with pytest.raises(ColonysimError, match=r"agent 0 at .*set, expected plain data.*needs methods 'state'"):
        colony.save(tmp_path / "saved.npz")
    assert not list(tmp_path.iterdir()) and events(colony)


class Noisy:
    """A backend of others with a clock, that says its state."""

    name, tick, edge_seconds = "noisy", 0.25, 1.0

    def __init__(self) -> None:
        self._mock = Mock(seconds=1.3, tick=0.25)

    def reset(self, world: Any, streams: Any) -> None:
        self._random = streams.generator("noise")
        self._mock.reset(world, streams)

    def start(self, agent: int, intent: Any, now: float) -> Any:
        self._mock._seconds = 0.3 + self._random.random()
        if self._random.random() < 0.1:
            self._mock._script = [Outcome("failed", self._mock._world.agent_node[agent], reason="noise")] * 10**4
        else:
            self._mock._script = ()
        return self._mock.start(agent, intent, now)

    def __getattr__(self, name: str) -> Any:
        if name in ("feasible", "footprint", "advance", "cancel", "leave", "rows", "close"):
            return getattr(self._mock, name)
        raise AttributeError(name)


class Telling(Noisy):
    def state(self) -> Any:
        return {"mock": self._mock.state(), "random": self._random.getstate()}

    def restore(self, state: Any) -> None:
        self._mock.restore(state["mock"])
        self._random.setstate(state["random"])

    def reseed(self, streams: Any) -> None:
        self._random = streams.generator("noise")


class Replayed(Noisy):
    replayable = True

    def reseed(self, streams: Any) -> None:
        self._random = streams.generator("noise")


@pytest.mark.parametrize("mode", ["asynchronous", "synchronous"])
@pytest.mark.parametrize("kind", [Telling, Replayed])
def test_backends_of_others_take_part(kind: Any, mode: str, tmp_path: Path) -> None:
    for number in range(8):
        colony = Colony("hard", seed=number, episodes=2, backend=kind(), mode=mode)
        for _ in range(1 + 9 * number):
            colony.step()
        colony.save(tmp_path / "saved.npz")
        fork, same = colony.fork(3, backend=kind()), colony.fork(3, backend=kind())
        with pytest.raises(ColonysimError, match="given as an object"):
            colony.fork(3)
        rest = events(colony)
        assert events(Colony.load(tmp_path / "saved.npz", backend=kind())) == rest != events(fork)
        assert events(same)
    with pytest.raises(ColonysimError, match="was given as an object; give another one, backend="):
        Colony.load(tmp_path / "saved.npz")


def test_changes_that_another_episode_had_make_no_other_moment(tmp_path: Path) -> None:
    """A backend that goes through the episode again does so in a process that has not seen the ones before."""
    place = {"topology": {"kind": "line", "nodes": 6}, "agents": [0], "goal": 5}
    changes = [{"time": 1, "to_episode": 1, "wipe": {}}, {"time": 2, "when": {"at_goal": 1}, "wipe": {}}]
    scenario = colonysim.scenario_from_document({**place, "changes": changes})
    colony = Colony(scenario, seed=1, episodes=2, backend=Replayed())
    colony.run_until(episode=1)
    colony.run_until(event="end")
    colony.save(tmp_path / "saved.npz")
    assert events(Colony.load(tmp_path / "saved.npz", backend=Replayed())) == events(colony)


def test_a_backend_that_does_not_take_part_is_refused(tmp_path: Path) -> None:
    colony = Colony("hard", seed=1, backend=Noisy())
    colony.run_until(time=5.0)
    with pytest.raises(ColonysimError, match=r"backend 'noisy' can neither say its state .*'replayable'"):
        colony.save(tmp_path / "saved.npz")

    class Deaf(Telling):
        reseed = None  # type: ignore[assignment]

    colony = Colony("hard", seed=1, backend=Deaf())
    colony.run_until(time=5.0)
    with pytest.raises(ColonysimError, match="no method 'reseed'"):
        colony.fork(1, backend=Deaf())


def test_a_replay_that_comes_elsewhere_is_refused(tmp_path: Path) -> None:
    class Otherwise(Replayed):
        def reset(self, world: Any, streams: Any) -> None:
            super().reset(world, streams)
            self._random.random()

    colony = Colony("hard", seed=1, backend=Replayed())
    colony.run_until(time=9.0)
    colony.save(tmp_path / "saved.npz")
    with pytest.raises(ColonysimError, match=r"came to (another moment|its end)"):
        Colony.load(tmp_path / "saved.npz", backend=Otherwise())


def test_code_of_others_is_not_imported_by_a_file(tmp_path: Path) -> None:
    for asked, words in (
        ({"policy": "colonysim.policies.uniform:Uniform"}, "its policy 'colonysim.policies.uniform:Uniform' is code"),
        ({"backend": "colonysim.backends.nodeworld:NodeWorld"}, "its backend 'colonysim.backends.nodeworld:NodeWorld'"),
    ):
        colony = Colony("hard", seed=1, **asked)  # type: ignore[arg-type]
        colony.run_until(time=5.0)
        colony.save(tmp_path / "saved.npz")
        with pytest.raises(ColonysimError, match=rf"saved\.npz: {words}"):
            Colony.load(tmp_path / "saved.npz")
        assert events(Colony.load(tmp_path / "saved.npz", **asked)) == events(colony)  # type: ignore[arg-type]


# -- files that are none -----------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def sound(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("saved") / "sound.npz"
    colony = Colony("hard", seed=1, episodes=2)
    colony.run_until(time=30.0)
    colony.save(path)
    return path


def rewritten(source: Path, target: Path, change: Any) -> Path:
    """A file whose text or arrays have been changed."""
    with zipfile.ZipFile(source) as old:
        parts = {name: old.read(name) for name in old.namelist()}
    text = json.loads(parts[TEXT])
    change(text, parts)
    parts[TEXT] = json.dumps(text).encode()
    with zipfile.ZipFile(target, "w") as new:
        for name, content in parts.items():
            new.writestr(name, content)
    return target


def test_it_is_an_archive_of_numpy_without_pickles(sound: Path) -> None:
    with np.load(sound, allow_pickle=False) as archive:
        text = json.loads(archive[TEXT])
        assert archive["state.world.agent_node"].tolist() == read_saved(sound).state["world"]["agent_node"].tolist()
        assert all(archive[name].dtype.kind in "iuf" for name in archive.files if name != TEXT)
    assert text["format"] == "colonysim colony" and text["colonysim"] == colonysim.__version__
    assert text["scenario_sha256"] == colonysim.load_scenario("hard").digest


def test_what_is_no_saved_colony(sound: Path, tmp_path: Path) -> None:
    path = tmp_path / "wrong.npz"
    for content in (b"", b"PK", b"x" * 1000, sound.read_bytes()[:-100], sound.read_bytes()[:200]):
        path.write_bytes(content)
        with pytest.raises(ColonysimError, match=r"wrong\.npz"):
            Colony.load(path)
    with zipfile.ZipFile(path, "w") as file:
        file.writestr("other.json", "{}")
    with pytest.raises(ColonysimError, match=r"holds no colony\.json"):
        Colony.load(path)
    with pytest.raises(ColonysimError, match="no such file"):
        Colony.load(tmp_path / "absent.npz")
    with pytest.raises(ColonysimError, match="is a directory"):
        Colony.load(tmp_path)
    with pytest.raises(ColonysimError, match="another scenario"):
        Colony.load(sound, scenario="easy")


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("format", "colonysim run", "not that of a colonysim colony"),
        ("schema", 99, "in format 99, this one reads format 3"),
        ("scenario_sha256", "0" * 64, "not the one that its hash tells of"),
        ("mode", "backwards", "no mode"),
        ("policy", "os:system", "is code of others"),
        ("backend", "os:system", "is code of others"),
        ("backend", "nodewold", "is code of others|no backend"),
        ("episodes", -3, "expected a whole number"),
        ("state", [1], "expected a state"),
    ],
)
def test_a_text_that_does_not_fit(name: str, value: Any, words: str, sound: Path, tmp_path: Path) -> None:
    path = rewritten(sound, tmp_path / "wrong.npz", lambda text, parts: text.update({name: value}))
    with pytest.raises(ColonysimError, match=words):
        Colony.load(path)


@pytest.mark.parametrize(
    "own",
    [
        {"policy": "antigravity:Policy"}, {"policy": {"extra_fields": ["antigravity:Field"]}},
        {"robot": "antigravity:ROBOT"}, {"robot": {"preset": "antigravity:ROBOT"}},
    ],
)  # fmt: skip
def test_code_of_others_that_a_group_names_is_not_imported(own: dict[str, Any], tmp_path: Path) -> None:
    group = {"name": "all", "agents": [0]}
    place = {"topology": {"kind": "line", "nodes": 5}, "goal": 4}
    colony = Colony(colonysim.scenario_from_document({**place, "groups": [group]}))
    colony.step()
    colony.save(tmp_path / "saved.npz")
    found = colonysim.scenario_from_document({**place, "groups": [{**group, **own}]})

    def other(text: Any, parts: Any) -> None:
        text |= {"scenario": found.document, "scenario_sha256": found.digest}

    with pytest.raises(ColonysimError, match=r"names code of others.*antigravity:\w+; give scenario="):
        Colony.load(rewritten(tmp_path / "saved.npz", tmp_path / "wrong.npz", other))


def npy(values: Any) -> bytes:
    file = io.BytesIO()
    np.lib.format.write_array(file, values)
    return file.getvalue()


def test_arrays_are_what_they_say(sound: Path, tmp_path: Path) -> None:
    name = "state.world.agent_node.npy"
    huge = npy(np.zeros(4, "<i4")).replace(b"(4,)", b"(4000000000000,)").replace(b" " * 13 + b"\n", b"\n")
    pickled = io.BytesIO()
    np.lib.format.write_array(pickled, np.array([print], dtype=object), allow_pickle=True)
    for content in (huge, pickled.getvalue(), b"no array", npy(np.zeros(4)), npy(np.zeros((2, 2), "<i4"))):
        path = rewritten(sound, tmp_path / "wrong.npz", lambda text, parts, c=content: parts.update({name: c}))
        with pytest.raises(ColonysimError, match=r"wrong\.npz"):
            Colony.load(path)
    path = rewritten(sound, tmp_path / "wrong.npz", lambda text, parts: parts.pop(name))
    with pytest.raises(ColonysimError, match="damaged"):
        Colony.load(path)

    def twice(text: Any, parts: Any) -> None:
        text["state"]["world"]["agent_from"] = text["state"]["world"]["agent_node"]

    with pytest.raises(ColonysimError, match="damaged"):
        Colony.load(rewritten(sound, tmp_path / "wrong.npz", twice))


def test_whatever_stands_in_it_the_answer_is_a_message(sound: Path, tmp_path: Path) -> None:
    """Arrays with any numbers, texts with any values: refused, or gone on with, and nothing else."""
    check_damage(sound, tmp_path, 150, 1)


@pytest.mark.slow
def test_whatever_stands_in_it_the_answer_is_a_message_10_000_times(sound: Path, tmp_path: Path) -> None:
    check_damage(sound, tmp_path, 10_000, 2)


def check_damage(sound: Path, folder: Path, count: int, seed: int) -> None:
    rng = random.Random(seed)
    odd: list[Any] = [-(2**31), -2, -1, 0, 1, 7, 2**31 - 1, 2**62, 2**80, 1e300, "x", None, True, [], {}, [[]], 0.5]
    refused = 0
    for _ in range(count):

        def damage(text: Any, parts: dict[str, bytes]) -> None:
            if rng.random() < 0.6:
                name = rng.choice([name for name in parts if name != TEXT])
                values = np.load(io.BytesIO(parts[name]))
                if len(values):
                    values[rng.randrange(len(values))] = rng.choice((0, 1, 3, 100)) if values.dtype.kind == "u" else (
                        rng.choice((-100, -2, -1, 0, 1, 50, 10**6, 2**31 - 1))
                    )  # fmt: skip
                parts[name] = npy(values[: rng.choice((None, None, None, -1))])
                return
            places: list[tuple[Any, Any]] = []

            def walk(value: Any) -> None:
                for key, item in list(value.items() if isinstance(value, dict) else enumerate(value)):
                    places.append((value, key))
                    if isinstance(item, (dict, list)):
                        walk(item)

            walk(text["state"])
            holder, key = rng.choice(places)
            holder[key] = rng.choice(odd)

        path = rewritten(sound, folder / "wrong.npz", damage)
        try:
            colony = Colony.load(path)
        except ColonysimError:
            refused += 1
            continue
        # What contradicts itself without pointing at anything that is not there may fail later on, as Python fails.
        with suppress(ColonysimError, ValueError, KeyError, AssertionError, IndexError, OverflowError), colony:
            for _ in range(400):
                if colony.step() is None:
                    break
    assert refused > 0.3 * count


def test_plain_data_is_copied_and_nothing_else() -> None:
    value = {"a": [1, (2.5, None)], 3: array("i", [1]), "n": np.float64(2.0)}
    twin = copied(value, "it")
    assert twin == value and twin["a"] is not value["a"] and type(twin["n"]) is np.float64
    knot: list[Any] = []
    knot.append(knot)
    for wrong in ({1, 2}, object(), knot, [Outcome("arrived", 1)], np.array(["a"]), NodeWorld()):
        with pytest.raises(ColonysimError):
            copied(wrong, "it")


class Odd:
    """What the agents remember is no plain data of a kind that could be written."""

    name = "odd"
    memory: ClassVar[Any] = None

    def __init__(self, scenario: Scenario) -> None:
        pass

    def fields(self, world: Any) -> dict[str, Any]:
        return {}

    def begin(self, agent: int, memory: Any) -> Any:
        return self.memory

    def decide(self, view: Any, memory: Any, random: Any) -> Choice:
        return Choice(Wait((), 1.0), memory)


@pytest.mark.parametrize(
    "memory",
    [array("l", [1]), array("u", "a"), "\ud800", 1 << 20_000, np.ma.masked_array([1, 2], [0, 1]), {1, 2}, object()],
    ids=["long", "letters", "surrogate", "huge", "masked", "set", "object"],
)  # fmt: skip
def test_memories_that_cannot_be_written_are_refused_by_save_and_fork_alike(memory: Any, tmp_path: Path) -> None:
    class Policy(Odd):
        pass

    Policy.memory = memory
    colony = Colony("sanity", policy=Policy, seed=1, episodes=1)
    colony.step()
    for keep in (lambda: colony.save(tmp_path / "saved.npz"), colony.fork):
        with pytest.raises(ColonysimError, match="plain data"):
            keep()
    assert not (tmp_path / "saved.npz").exists()


@pytest.mark.parametrize("mode", ["asynchronous", "synchronous"])
def test_an_episode_that_time_has_cut_off_can_be_kept_too(mode: str, tmp_path: Path) -> None:
    scenario = colonysim.load_scenario("hard", None, {"time_limit": 6.5})
    colony = Colony(scenario, seed=2, episodes=2, mode=mode)
    last = colony.run_until(episode=1)
    assert last is not None and last.status == "timeout"
    colony.save(tmp_path / "saved.npz")
    rest = events(colony.fork())
    assert events(Colony.load(tmp_path / "saved.npz")) == rest
    colony.change({"policy": {"beta": 4.0}})  # as it was
    assert [event for event in events(colony) if event.kind != "change"] == rest
