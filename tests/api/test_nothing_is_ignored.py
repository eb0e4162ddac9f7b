"""What is asked for is done, or it is refused: no argument and no option is without effect."""

from __future__ import annotations

import ast
import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

import colonysim
from colonysim.backends.nodeworld import NodeWorld
from colonysim.cli import app
from colonysim.errors import ColonysimError, PluginError
from colonysim.plots import draw
from colonysim.policies.uniform import Uniform

PACKAGE = Path(colonysim.__file__).parent
PROTOCOLS = {
    # methods that a protocol gives arguments which not everybody needs
    "__exit__", "advance", "at", "begin", "cancel", "feasible", "fields", "footprint", "keys", "reset", "start",
    "_wait", "_stop", "note",  # signal handlers
    "undertake", "come",  # what the simulation asks of backends, and SimPy's callbacks
    "scripted",  # an executor without chance
    "state", "reseed",  # of a memory whoever it is of, and of what draws nothing
    "take_over",  # of a policy that remembers nothing of its parameters
    "decide", "deposit", "handle_error", "_show_warning",  # what the bench brings, what a server and `warnings` call
}  # fmt: skip


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    return colonysim.run("sanity", episodes=2, seed=1, out=tmp_path_factory.mktemp("runs") / "run")


def cli(*words):
    return CliRunner().invoke(app, [str(word) for word in words])


def unread(function):
    """Arguments that the body of a function never looks at, unless it only says what others do."""
    arguments = function.args
    names = {each.arg for each in (*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs)} - {"self", "cls"}
    names |= {each.arg for each in (arguments.vararg, arguments.kwarg) if each is not None}
    body = [node for node in function.body if not (isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant))]
    if not body or isinstance(body[0], (ast.Raise, ast.Pass)):
        return set()
    return names - {node.id for part in body for node in ast.walk(part) if isinstance(node, ast.Name)}


def test_every_function_reads_its_arguments():
    found = [
        f"{path.relative_to(PACKAGE)}:{node.lineno}: {node.name}: {', '.join(sorted(unread(node)))}"
        for path in sorted(PACKAGE.rglob("*.py"))
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.FunctionDef) and node.name not in PROTOCOLS and unread(node)
    ]
    assert not found


def test_a_scenario_that_is_loaded_takes_no_variant_and_no_overrides(folder):
    scenario = colonysim.load_scenario("hard")
    for more in ({"variant": "r5-6"}, {"overrides": {"policy.beta": 1}}, {"overrides": ["policy.beta=1"]}):
        with pytest.raises(ColonysimError, match="the scenario is loaded already"):
            colonysim.run(scenario, episodes=1, **more)
    assert not list(folder.iterdir())


def test_a_manifest_says_which_variant_and_settings_a_scenario_was_loaded_with(folder):
    settings = ["policy.beta=2", "agents=[2, 8]", "agents.0=1", "time_limit=null", "mode=synchronous"]
    scenario = colonysim.load_scenario("hard", "r5-4", settings)
    one = colonysim.run(scenario, episodes=1, out="one")
    two = colonysim.run("hard", variant="r5-4", overrides=settings, episodes=1, out="two")
    words = [word for text in settings for word in ("--set", text)]
    assert cli("run", "hard", "-v", "r5-4", *words, "-n", 1, "-o", "three").exit_code == 0
    three = colonysim.Run.open("three")
    said = {"policy.beta": 2, "agents": [1, 8], "agents.0": 1, "time_limit": None, "mode": "synchronous"}
    for each in (one, two, three):
        assert each.manifest["variant"] == "r5-4" and each.manifest["options"]["overrides"] == said
        assert each.trace_sha256 == one.trace_sha256
    compared = json.loads(cli("compare", "one", "two", "--json").stdout)["differences"]
    assert {row["by"] for row in compared} == {"source"} and all(row["difference"] == 0 for row in compared)
    document = {**scenario.document, "variants": {"slow": {"max_steps": 9}}}
    other = colonysim.scenario_from_document(document, variant="slow")
    assert other.variant == "slow" and scenario.settings == said


def test_what_a_run_would_not_look_at(run, folder):
    scenario = colonysim.load_scenario("sanity")
    for call in (colonysim.run, lambda *a, **k: list(colonysim.simulate(*a, **k))):
        with pytest.raises(ColonysimError, match="backend options push: only with a backend given by its name"):
            call(scenario, backend=NodeWorld(), backend_options={"push": "rl"})
    with pytest.raises(ColonysimError, match="nothing is written there without a trace"):
        colonysim.run(scenario, trace=False, out="here")
    with pytest.raises(ColonysimError, match="this policy would not see them, its own are: none"):
        colonysim.run(scenario, policy=Uniform, initial=run)
    assert not list(folder.iterdir())


def test_what_a_drawing_would_not_show(run, folder):
    hole = run.scenario.topology.ids[run.scenario.holes[0].node]
    for options, message in [
        ({"what": ["map"], "hole": hole}, "only with a field that has a value for each hole"),
        ({"what": ["D", "H"], "box": 0}, "only with a field that has a value for each box"),
        ({"what": "episodes", "episodes": [1]}, "show the whole run"),
        ({"what": ["workload", "fates"], "episodes": [1]}, "show the whole run"),
        ({"what": []}, "expected at least one"),
    ]:
        with pytest.raises(ColonysimError, match=message):
            draw(run, out=folder / "plots", **options)
    assert not list(folder.iterdir())


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("run sanity --no-trace -o here", "--no-trace and --out"),
        ("run sanity --pace 3", "--pace: only a run with --live, or a node world with --watch"),
        ("run sanity --backend mock --watch --pace 3", "--pace: only a run with --live, or a node world with --watch"),
        ("run sanity --port 8000", "--port: only with --live"),
        ("run sanity --no-open", "--no-open: only with --live"),
        ("run sanity --push rl", "the node world has no bodies"),
        ("run sanity --backend mock --push rl", "does not take these options"),
        ("run sanity --seed -1", "seed: -1, expected a whole number from 0"),
        ("run sanity --seed 1000000000000000000", "seed: 1000000000000000000, expected"),
        ("scenarios hard --json", "--json: of the list only"),
        ("bench --list hard", "--list stands alone"),
        ("bench --list --json", "--list stands alone"),
        ("reproduce --list --quick", "--list stands alone"),
        ("reproduce push -o out --physics x.jsonl", "of use to 'performance-physics' only"),
        ("reproduce --list --engine mujoco", "--list stands alone"),
        ("train push --set engine=mujoco -o here", "an option of its own, --engine"),
        ("reproduce hole-edge-case -o out --trainings x.jsonl", "of use to 'push' only"),
        ("results out --sql 'SELECT 1' --episodes 1-2", "--sql stands alone"),
        ("results out --sql 'SELECT 1' --by seed", "--sql stands alone"),
        ("evaluate push --push scripted --model x.npz -o here", "scripted pushes need no network"),
        ("evaluate push -n 1000000001 -o here", "episodes: 1000000001, expected"),
        ("new grid --size 5 -o here", "rooms and platforms have one"),
        ("new rooms --depth 2 -o here", "there are no holes"),
        ("new geometric --spare 2 -o here", "without holes and boxes"),
    ],
)
def test_an_option_that_would_be_without_effect_is_refused(words, message, folder):
    import shlex

    refused = cli(*shlex.split(words))
    assert refused.exit_code == 2 and message in refused.output and refused.output.startswith("Error: "), refused.output
    assert "Traceback" not in refused.output and not list(folder.iterdir())


class Unready(NodeWorld):
    """A backend that cannot be set up for the scenario."""

    def reset(self, world, streams):
        raise RuntimeError("no such place")


class Late(NodeWorld):
    """A backend that fails at the first action."""

    def start(self, agent, intent, now):
        raise RuntimeError("out of order")


@pytest.mark.parametrize("out", [None, "a/b/c", "there"])
def test_a_run_that_could_not_start_leaves_no_directory(folder, out):
    (folder / "there").mkdir()
    with pytest.raises(PluginError, match="no such place"):
        colonysim.run("sanity", backend=Unready(), out=out)
    with pytest.raises(KeyError):
        colonysim.run("sanity", out=out, on_start=lambda run: {}["missing"])
    assert [path.name for path in folder.rglob("*")] == ["there"]
    with pytest.raises(PluginError, match="out of order"):
        colonysim.run("sanity", backend=Late(), out=out or "late")
    assert colonysim.Run.open(out or "late").status == "failed"


def test_a_place_that_physics_cannot_build_leaves_no_directory(folder, some_engine):
    document = colonysim.load_scenario("sanity").document | {"physics": {"xy_scale": 0.05}}
    with pytest.raises(ColonysimError):
        colonysim.run(colonysim.scenario_from_document(document), backend=some_engine, episodes=1)
    assert not list(folder.iterdir())
