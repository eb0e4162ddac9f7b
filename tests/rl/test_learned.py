"""Learned policies: their files, and that the simulation runs them as an environment does that they drive."""

from __future__ import annotations

import json
import random
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from onnx_files import perceptron

pytest.importorskip("pettingzoo")

from typer.testing import CliRunner

import colonysim
from colonysim import rl
from colonysim.cli import app
from colonysim.errors import ColonysimError, ScenarioError
from colonysim.installing import install_command
from colonysim.learning.cards import ModelError
from colonysim.rl.learned import Learned
from colonysim.rl.spaces import sizes_of
from colonysim.testing import check_policy, random_scenario
from colonysim.trace.reader import Run

ROWS = {"neighbours": 8, "boxes": 3, "holes": 2}
"""Rows of an observation that fit every place of these tests."""


def layers_for(options, seed=0, hidden=24):
    inputs, actions = sizes_of(options)
    rng, rest = np.random.default_rng(seed), np.zeros(actions)
    rest[-2:] = -100.0  # who waits for ever makes no trace to compare
    return [
        (rng.normal(size=(hidden, inputs)).astype(np.float32), rng.normal(size=hidden).astype(np.float32)),
        ((0.1 * rng.normal(size=(actions, hidden))).astype(np.float32), rest.astype(np.float32)),
    ]


def saved(folder: Path, scenario="hard", *, seed=0, name="policy", options=None, **how) -> Path:
    env = rl.aec(scenario, flat=True, **(options or {}))
    layers = layers_for(env.turns.observer.options, seed)
    return rl.save_policy(folder / f"{name}.npz", layers, env, **how)


def drive(env, model):
    """An episode in which a network decides from the outside."""
    for _ in env.agent_iter():
        observation, _, terminated, truncated, info = env.last()
        env.step(None if terminated or truncated else model.act(observation, info["action_mask"]))


OPTIONS = {
    "as it is": {},
    "padded": ROWS,
    "which hole": {"hole": "action", **ROWS},
    "no pheromones": {"parts": ("self", "neighbours", "boxes")},
    "few boxes": {"boxes": 1, "holes": 1},
    "sensors that err": {"overrides": {"faults": {"box_missed": 0.2, "node_misplaced": 0.2, "mark_noise": 0.3}}},
}


@pytest.mark.parametrize("mode", ["asynchronous", "synchronous"])
@pytest.mark.parametrize("options", OPTIONS.values(), ids=OPTIONS)
def test_a_native_run_has_the_trace_hash_of_an_environment_that_the_network_drives(options, mode, tmp_path):
    for variant in (None, "r5-6"):
        folder = tmp_path / str(variant)
        overrides = options.get("overrides", {})
        asked = {**options, "overrides": {"episodes": 2, **overrides}}
        env = rl.aec("hard", variant=variant, mode=mode, flat=True, pheromones="keep", trace=folder, **asked)
        card = rl.save_policy(tmp_path / "policy.npz", layers_for(env.turns.observer.options, 2), env)
        model = rl.load_policy(card)
        env.reset(seed=3)
        drive(env, model)
        env.reset()
        drive(env, model)
        env.close()
        played = Run.open(folder / "run-000001").manifest
        native = colonysim.run(
            "hard", variant=variant, policy="learned", mode=mode, seed=3, episodes=2, trace=False,
            overrides={**overrides, "policy.model": str(card)},
        )  # fmt: skip
        assert played["trace_sha256"] == native.manifest["trace_sha256"]
        assert played["rows"] == native.manifest["rows"] and played["rows"]["events"] > 100
        assert native.manifest["policy"] == "learned"


def test_it_has_it_in_physics(some_engine, tmp_path):
    card = saved(tmp_path, "sanity")
    overrides = {"max_steps": 12, "time_limit": 200}
    env = rl.aec("sanity", backend=some_engine, flat=True, trace=tmp_path / "env", overrides=overrides)
    env.reset(seed=1)
    drive(env, rl.load_policy(card))
    env.close()
    native = colonysim.run(
        "sanity", backend=some_engine, policy="learned", seed=1, episodes=1, trace=False,
        overrides={**overrides, "policy.model": str(card)},
    )  # fmt: skip
    assert Run.open(tmp_path / "env" / "run-000001").manifest["trace_sha256"] == native.trace_sha256


def test_an_onnx_file_decides_as_the_same_layers_do(tmp_path):
    pytest.importorskip("onnxruntime")
    env = rl.aec("hard", flat=True)
    options = env.turns.observer.options
    layers = layers_for(options, 3)
    plain = rl.save_policy(tmp_path / "plain.npz", layers, env)
    card = rl.save_policy(tmp_path / "net.onnx", perceptron(layers), options, marks="colony")
    hashes = {
        colonysim.run("hard", policy="learned", overrides={"policy.model": str(file)}, episodes=1, trace=False)
        .trace_sha256 for file in (plain, card, tmp_path / "net.onnx", tmp_path / "plain.npz")
    }  # fmt: skip
    assert len(hashes) == 1
    with pytest.raises(ModelError, match=r"net\.onnx: has the input .*expected one input"):
        rl.save_policy(tmp_path / "net.onnx", perceptron(layers_for({**options, "boxes": 1})), options, marks="colony")
    (tmp_path / "net.onnx").write_bytes(perceptron(layers_for(options, 4)))
    with pytest.raises(ModelError, match=r"net\.onnx: SHA-256 is .*, the card says"):
        rl.load_policy(card)


def test_a_network_of_tanh_is_another_one(tmp_path):
    cards = [saved(tmp_path, name=word, activation=word) for word in ("relu", "tanh")]
    told = np.random.default_rng(0).normal(size=(5, sizes_of(rl.load_policy(cards[0]).observation)[0]))
    relu, tanh = (rl.load_policy(card).values(told) for card in cards)
    [(w0, b0), (w1, b1)] = rl.load_policy(cards[0]).network
    assert np.allclose(tanh, np.tanh(told.astype(np.float32) @ w0.T + b0) @ w1.T + b1, atol=1e-4)
    assert np.allclose(relu, np.maximum(told.astype(np.float32) @ w0.T + b0, 0) @ w1.T + b1, atol=1e-4)


def test_an_action_is_never_one_that_is_not_allowed(tmp_path):
    model, rng = rl.load_policy(saved(tmp_path)), np.random.default_rng(1)
    inputs, actions = sizes_of(model.observation)
    for _ in range(200):
        told, mask = rng.normal(size=inputs), rng.random(actions) < 0.3
        mask[rng.integers(actions)] = True
        values = model.values(told)
        assert model.act(told, mask) == int(np.where(mask, values, -np.inf).argmax())
        assert mask[model.act(told, mask, random.Random(1))]
    same, free = np.zeros(inputs), np.ones(actions)
    stream = random.Random(2)
    drawn = np.bincount([model.act(same, free, stream) for _ in range(3000)], minlength=actions) / 3000
    wanted = np.exp(model.values(same).astype(float))
    assert drawn == pytest.approx(wanted / wanted.sum(), abs=0.04)


def test_sampled_decisions_come_from_the_seed_and_the_scenario_says_which_way_it_is(tmp_path):
    card = saved(tmp_path, choice="sampled")

    def played(seed, **parameters):
        fields = {f"policy.{name}": value for name, value in {"model": str(card), **parameters}.items()}
        return colonysim.run("hard", policy="learned", overrides=fields, seed=seed, episodes=1, trace=False)

    assert played(1).trace_sha256 == played(1, choice="sampled").trace_sha256
    assert len({played(1).trace_sha256, played(2).trace_sha256, played(1, choice="greedy").trace_sha256}) == 3


def test_it_keeps_the_promises_of_a_policy(tmp_path):
    card = saved(tmp_path, options=ROWS, choice="sampled")

    def learned(scenario):
        return Learned(replace(scenario, parameters={"model": str(card)}))

    check_policy(learned, worlds=40, runs=3)


def test_one_network_fits_many_places(tmp_path):
    card = saved(tmp_path, options=ROWS)
    for place in (*map(colonysim.load_scenario, ("sanity", "easy", "medium")), random_scenario(11)):
        own = colonysim.scenario_from_document({**place.document, "policy": {"name": "learned", "model": str(card)}})
        assert colonysim.run(own, episodes=1, trace=False).episodes[0].sim_seconds > 0.0


def test_the_policy_that_comes_with_the_package_runs_by_its_name(tmp_path):
    assert rl.shipped_policies() == ("small-worlds",)
    model = rl.load_policy("small-worlds")
    assert model.card["how"]["config"]["name"] == "small" and model.marks == "colony"
    done = CliRunner().invoke(app, ["run", "hard", "--policy", "learned", "--set", "policy.model=small-worlds",
                                    "--episodes", "1", "--out", str(tmp_path / "run")])  # fmt: skip
    assert done.exit_code == 0, done.output
    assert Run.open(tmp_path / "run").manifest["policy"] == "learned"
    with pytest.raises(ModelError, match=r"small-world: is no model; expected .*, or small-worlds"):
        rl.load_policy("small-world")


def test_on_worlds_like_those_of_its_training_it_is_faster_than_the_rule():
    from colonysim.learning.seeds import Purpose
    from colonysim.rl.training.places import place

    def seconds(number, policy):
        scenario = colonysim.scenario_from_document({**place(Purpose.TUNE, number).document, "policy": policy})
        episodes = colonysim.run(scenario, episodes=2, seed=9, trace=False).episodes
        return [e.sim_seconds if e.success == 1.0 else scenario.time_limit for e in episodes]

    learned, rule = (
        [time for number in range(6) for time in seconds(number, policy)]
        for policy in ({"name": "learned", "model": "small-worlds"}, {"name": "colony"})
    )
    assert sum(learned) < 0.9 * sum(rule)


def test_a_scenario_names_the_model_beside_its_own_file(tmp_path, monkeypatch):
    (tmp_path / "maps" / "nets").mkdir(parents=True)
    monkeypatch.chdir(tmp_path)
    saved(tmp_path / "maps" / "nets", "sanity")
    policy = {"name": "learned", "model": "nets/policy.json"}
    document = {**colonysim.load_scenario("sanity").document, "policy": policy}
    document["variants"] = {"sampled": {"policy": {"choice": "sampled"}}, "own": {"policy": {"model": "nets/no.json"}}}
    (tmp_path / "maps" / "own.yaml").write_text(yaml.safe_dump(document))
    run = colonysim.run("maps/own.yaml", seed=1, out="run", episodes=1)
    assert run.manifest["scenario"]["policy"]["model"] == "maps/nets/policy.json"
    told = run.manifest["sources"]["policy.model maps/nets/policy.json"]
    assert set(told) == {"policy.json", "policy.npz"} and all(len(each) == 7 + 64 for each in told.values())
    assert f"sha256 {json.loads(Path('maps/nets/policy.json').read_text())['sha256']}" == told["policy.npz"]
    assert CliRunner().invoke(app, ["validate", "maps/own.yaml", "--variant", "sampled"]).exit_code == 0
    assert CliRunner().invoke(app, ["verify", "run"]).exit_code == 0
    with pytest.raises(ScenarioError, match=r"own\.yaml:\d+:\d+: policy\.model: maps/nets/no\.json"):
        colonysim.run("maps/own.yaml", variant="own", trace=False)
    elsewhere = colonysim.run(
        "maps/own.yaml", overrides={"policy.model": "maps/nets/policy.npz"}, seed=1, trace=False, episodes=1
    )
    assert elsewhere.trace_sha256 == run.trace_sha256


def test_a_colony_is_saved_loaded_and_forked_with_it(tmp_path):
    card = saved(tmp_path, choice="sampled")
    scenario = colonysim.load_scenario("hard", overrides={"policy.model": str(card)})

    def made():
        return colonysim.Colony(scenario, policy="learned", episodes=2, seed=5)

    with made() as colony:
        expected = list(colony)
    with made() as colony:
        colony.run_until(time=30)
        colony.save(tmp_path / "saved.npz")
        twin, rest = colony.fork(), list(colony)
        assert rest == expected[-len(rest) :] and list(twin) == rest
    with colonysim.Colony.load(tmp_path / "saved.npz") as loaded:
        assert list(loaded) == rest
    saved(tmp_path, choice="sampled", seed=1)
    with pytest.raises(ColonysimError, match=r"saved with .*, whose file policy\.json is another one now"):
        colonysim.Colony.load(tmp_path / "saved.npz")


def test_a_network_that_is_replaced_under_way_is_not_taken_for_the_one_that_decides(tmp_path):
    card = saved(tmp_path)
    scenario = colonysim.load_scenario("hard", overrides={"policy.model": str(card)})
    with colonysim.Colony(scenario, policy="learned", seed=5) as colony:
        colony.run_until(time=30)
        saved(tmp_path, seed=1)
        colony.save(tmp_path / "saved.npz")
        with pytest.raises(ColonysimError, match=r"saved with .*, whose file policy\.json is another one now"):
            colony.fork()
    with pytest.raises(ColonysimError, match=r"saved with .*, whose file policy\.json is another one now"):
        colonysim.Colony.load(tmp_path / "saved.npz")


def test_a_run_is_resumed_with_its_network_and_with_no_other(tmp_path):
    card = saved(tmp_path)

    def stop(event, run):
        if event.kind == "episode" and event.episode == 2:
            raise KeyboardInterrupt

    how = {"policy": "learned", "overrides": {"policy.model": str(card)}, "episodes": 4, "seed": 1}
    whole = colonysim.run("hard", trace=False, **how)
    with pytest.raises(KeyboardInterrupt):
        colonysim.run("hard", out=tmp_path / "run", checkpoint_every=0.01, on_event=stop, **how)
    saved(tmp_path, seed=1)
    with pytest.raises(ColonysimError, match=r"recorded with .*, whose file policy\.json is another one now"):
        colonysim.resume(tmp_path / "run")
    saved(tmp_path)
    assert colonysim.resume(tmp_path / "run").trace_sha256 == whole.trace_sha256


def test_sweeps_take_it_and_notice_another_one(tmp_path, monkeypatch):
    from colonysim.sweep.plan import load_sweep
    from colonysim.sweep.running import run_sweep

    monkeypatch.chdir(tmp_path)
    saved(tmp_path, "sanity")
    Path("sweep.yaml").write_text(
        "scenarios: [sanity]\npolicies: [learned]\ngrid: {policy.model: [policy.json]}\nseeds: [1, 2]\nepisodes: 1\n"
    )
    before = load_sweep("sweep.yaml").trials
    assert len(before) == 2 and "policy.model policy.json" in before[0].sources
    run_sweep("sweep.yaml", "res", workers=1)
    saved(tmp_path, "sanity", seed=1)
    after = load_sweep("sweep.yaml").trials
    assert not {trial.identity for trial in before} & {trial.identity for trial in after}


def changed_card(folder, **fields):
    card = saved(folder)
    content = json.loads(card.read_text())
    for name, value in fields.items():
        if name in content:
            content[name] = value
        else:
            content["observation"][name] = value
    card.write_text(json.dumps(content))
    return card


WRONG = {
    "another kind": ({"kind": "q-network"}, "expected a 'colony-policy' of format 1"),
    "unknown activation": ({"activation": "gelu"}, "activation: is 'gelu', expected one of relu, tanh"),
    "unknown choice": ({"choice": "best"}, "choice: is 'best', expected one of greedy, sampled"),
    "marks of others": ({"marks": "os:system"}, "marks: is 'os:system', expected a policy that leaves marks"),
    "itself": ({"marks": "learned"}, "marks: is 'learned', expected a policy that leaves marks"),
    "no part": ({"parts": ["self", "smell"]}, r"observation\.parts: is \['self', 'smell'\], expected some of self"),
    "rows": ({"boxes": -1}, r"observation\.boxes: is -1, expected a number of rows, 0 to"),
    "too many": ({"neighbours": 10**9}, r"observation\.neighbours: is 1000000000, expected a number of rows"),
    "sizes": ({"boxes": 1}, r"policy\.npz: layer 0 has weights .*; observations have \d+ numbers, and there are \d+"),
    "hash": ({"sha256": "0" * 64}, "the card says 000"),
}  # fmt: skip


@pytest.mark.parametrize("case", WRONG)
def test_a_file_that_does_not_fit_is_refused_in_one_line(case, tmp_path):
    fields, told = WRONG[case]
    card = changed_card(tmp_path, **fields)
    with pytest.raises(ModelError, match=told) as caught:
        rl.load_policy(card)
    assert str(tmp_path) in str(caught.value) and "\n" not in str(caught.value)
    done = CliRunner().invoke(app, ["run", "hard", "-p", "learned", "--set", f"policy.model={card}", "--no-trace"])
    assert done.exit_code == 2 and done.output.startswith("Error: --set policy.model=")
    assert done.output.count("\n") == 1


def test_what_a_scenario_cannot_have_decided_is_told(tmp_path):
    card = saved(tmp_path, "sanity")

    def run(scenario="sanity", **parameters):
        fields = {f"policy.{name}": value for name, value in parameters.items()}
        colonysim.run(scenario, policy="learned", overrides=fields, episodes=1, trace=False)

    with pytest.raises(ScenarioError, match=r"policy\.model: the policy 'learned' needs a network; expected"):
        run()
    with pytest.raises(ScenarioError, match=r"policy\.model: .* needs a network; did you mean 'modle'"):
        run(modle=str(card))
    with pytest.raises(ScenarioError, match=r"policy\.choice=gredy: is 'gredy'; did you mean 'greedy'"):
        run(model=str(card), choice="gredy")
    with pytest.raises(ScenarioError, match=r"policy\.betta=2: no such parameter; did you mean 'beta'"):
        run(model=str(card), betta=2)
    with pytest.raises(ScenarioError, match=r"markless\.json: was told of the fields D, .*, and here are none"):
        run(model=str(changed_marks(card)))
    narrow = saved(tmp_path, "sanity", name="narrow")
    most = colonysim.load_scenario("hard").topology.most_neighbours
    assert rl.load_policy(narrow).observation["neighbours"] < most
    with pytest.raises(ScenarioError, match=rf"a node has {most} neighbours, and observations tell of \d"):
        run("hard", model=str(narrow))


def changed_marks(card: Path) -> Path:
    """The same policy, whose agents leave no marks."""
    content = json.loads(card.read_text())
    content["marks"] = "random"
    other = card.with_name("markless.json")
    other.write_text(json.dumps(content))
    other.with_suffix(".npz").write_bytes(card.with_suffix(".npz").read_bytes())
    return other


@pytest.mark.parametrize(
    ("network", "how", "told"),
    [
        ([], {}, "0 layers"),
        ([("a", "b")], {}, "layer 0|expected weights and biases|network: "),
        ([(np.zeros((4, 3)), np.zeros(4))], {}, r"layer 0 has weights \(4, 3\)"),
        (None, {"activation": "gelu"}, "activation: is 'gelu'"),
        (None, {"choice": "best"}, "choice: is 'best'"),
        (None, {"marks": "mine:Marks"}, "marks: is 'mine:Marks'"),
    ],
)
def test_what_cannot_be_saved_is_told_and_nothing_is_written(network, how, told, tmp_path):
    env = rl.aec("sanity", flat=True)
    network = layers_for(env.turns.observer.options) if network is None else network
    with pytest.raises(ModelError, match=told):
        rl.save_policy(tmp_path / "p.npz", network, env, **how)
    assert not [*tmp_path.iterdir()]


def test_weights_that_are_no_numbers_are_refused(tmp_path):
    env = rl.aec("sanity", flat=True)
    layers = layers_for(env.turns.observer.options)
    layers[1][0][0, 0] = np.nan
    with pytest.raises(ModelError, match="array 'w1' holds a number"):
        rl.save_policy(tmp_path / "p.npz", layers, env)
    with pytest.raises(ModelError, match=r"expected a name that ends in \.npz"):
        rl.save_policy(tmp_path / "p.pt", layers, env)


def test_a_learned_policy_runs_where_gymnasium_and_pettingzoo_are_not_installed(tmp_path):
    card = saved(tmp_path, "sanity")
    code = (
        "import sys\nsys.modules['gymnasium'] = sys.modules['pettingzoo'] = None\n"
        "import colonysim\nfrom colonysim import rl\nfrom colonysim.errors import MissingExtraError\n"
        f"run = colonysim.run('sanity', policy='learned', overrides={{'policy.model': {str(card)!r}}}, episodes=1,"
        " trace=False)\nprint(run.trace_sha256)\n"
        "try:\n    rl.aec('sanity')\nexcept MissingExtraError as error:\n    print(error)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120)
    native = colonysim.run("sanity", policy="learned", overrides={"policy.model": str(card)}, episodes=1, trace=False)
    assert done.stdout.split("\n")[0] == native.trace_sha256, done.stderr
    assert install_command("rl") in done.stdout


def test_a_run_in_which_it_took_the_place_of_the_scenario_s_policy_is_repeated(tmp_path):
    card = saved(tmp_path)
    asked = {"policy": "learned", "overrides": {"policy.model": str(card)}, "seed": 1, "episodes": 1}
    run = colonysim.run("hard", out=tmp_path / "run", **asked)
    assert colonysim.repeat(run.path, out=tmp_path / "again").trace_sha256 == run.trace_sha256
