"""Networks of one's own push: a card that a training has written, and ONNX files with the same inputs and outputs."""

from __future__ import annotations

import hashlib
import json
import re
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from onnx_files import perceptron
from typer.testing import CliRunner

import colonysim
from colonysim.cli import app
from colonysim.errors import ColonysimError, MissingExtraError
from colonysim.installing import install_command
from colonysim.learning.cards import ModelError, load_model, save_model
from colonysim.learning.seeds import Purpose, episode_rng
from colonysim.push.executors import make_executor
from colonysim.push.network import load_network, open_network
from colonysim.push.training.evaluation import play_push
from colonysim.push.training.starts import distribution, draw

SHIPPED = load_model("push", "q-network")
LAYERS = load_network().layers
QUICK = {"max_steps": 6, "time_limit": 60}


def own_card(folder: Path, *, scale: float = 1.0) -> Path:
    """A network that was trained by somebody: the shipped one, with other values."""
    arrays = {name: array * (scale if name in ("w3", "b3") else 1.0) for name, array in SHIPPED.arrays.items()}
    save_model(folder / "mine.npz", "q-network", arrays, {"inputs": "line", "ticks": 15})
    return folder / "mine.json"


def onnx(folder: Path, **how) -> Path:
    pytest.importorskip("onnxruntime")
    how = {"layers": LAYERS, "metadata": {"ticks": "15"}, **how}
    (folder / "net.onnx").write_bytes(perceptron(**how))
    return folder / "net.onnx"


def test_an_onnx_file_gives_the_values_of_the_same_network_in_plain_arrays(tmp_path):
    network, ticks = open_network(onnx(tmp_path))
    states = np.random.default_rng(3).normal(size=(20, 9))
    assert ticks == 15
    assert np.allclose(network.values(states), load_network().values(states), rtol=1e-4, atol=1e-4)
    assert np.allclose(network.values(states[0]), load_network().values(states[0]), rtol=1e-4, atol=1e-4)


def test_one_row_at_a_time_and_nine_numbers_will_do_too(tmp_path):
    rng = np.random.default_rng(0)
    layers = [(rng.normal(size=(16, 9)), rng.normal(size=16)), (rng.normal(size=(8, 16)), rng.normal(size=8))]
    network, ticks = open_network(onnx(tmp_path, layers=layers, rows=1, metadata={}))
    assert (network.inputs, ticks) == ("state", 50)
    assert network.values(np.zeros((3, 9))).shape == (3, 8) and network.values(np.zeros(9)).shape == (8,)


def test_it_pushes(tmp_path, some_engine):
    start = draw("flat", distribution("push"), episode_rng(Purpose.TEST, 5, 0, 0))
    assert play_push(start, make_executor("staged", model=onnx(tmp_path))).success


SEVEN = [(LAYERS[0][0][:, :7], LAYERS[0][1]), *LAYERS[1:]]
NAN = [(weights * np.float32("nan"), biases) for weights, biases in LAYERS]
REFUSED = {
    "input of 7": ({"layers": SEVEN}, r"expected one input of type tensor\(float\) and shape \(n, 9 or 23\)"),
    "too few outputs": (
        {"layers": [*LAYERS[:-1], (LAYERS[-1][0][:5], LAYERS[-1][1][:5])]}, r"output .*\[.*5\]; expected .*\(n, 8\)"
    ),
    "numbers of another type": ({"kind": 11}, r"double|is no ONNX model that can be run"),
    "two outputs": ({"more_outputs": True}, "has the outputs 'values'.* 'z0'.*; expected one output"),
    "NaN": ({"layers": NAN}, "gives a value that is no finite number"),
    "ticks that are none": ({"metadata": {"ticks": "soon"}}, "ticks is 'soon', expected 1 to 10000 control ticks"),
    "no ticks at all": ({"metadata": {"ticks": "0"}}, "ticks is '0', expected 1 to 10000 control ticks"),
    "an operation that there is not": ({"activation": "Fry"}, "is no ONNX model that can be run"),
    "what it says of itself": ({"outputs": 8, "layers": LAYERS[:-1]}, "net.onnx: "),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_an_onnx_file_that_does_not_fit_is_refused_in_one_line(case, tmp_path):
    how, told = REFUSED[case]
    with pytest.raises(ModelError, match=told) as caught:
        open_network(onnx(tmp_path, **how))
    assert "net.onnx" in str(caught.value) and "\n" not in str(caught.value)


@pytest.mark.parametrize("content", [b"", b"no model", perceptron(LAYERS)[:500]])
def test_a_damaged_onnx_file_is_refused(content, tmp_path):
    file = onnx(tmp_path)
    file.write_bytes(content)
    with pytest.raises(ModelError, match="is no ONNX model that can be run"):
        open_network(file)


def test_without_onnx_runtime_it_is_told_what_to_install(tmp_path, monkeypatch):
    (tmp_path / "net.onnx").write_bytes(b"whatever")
    monkeypatch.setitem(sys.modules, "onnxruntime", None)
    with pytest.raises(MissingExtraError, match=re.escape(install_command("onnx"))):
        open_network(tmp_path / "net.onnx")


def invoke(*words):
    done = CliRunner().invoke(app, [str(word) for word in words])
    return done.exit_code, done.output


def test_a_run_pushes_with_the_network_that_it_is_given_and_the_manifest_names_it(tmp_path, some_engine, monkeypatch):
    monkeypatch.chdir(tmp_path)
    card = own_card(tmp_path, scale=-1.0)
    fields = [f"--set={name}={value}" for name, value in QUICK.items()]
    asked = ["run", "sanity", *fields, "-b", some_engine, "--push", "rl", "-n1", "-q"]
    assert invoke(*asked, "--out", "mine", "--model", card)[0] == 0
    assert invoke(*asked, "--out", "theirs")[0] == 0
    mine, theirs = (colonysim.Run.open(name) for name in ("mine", "theirs"))
    assert mine.trace_sha256 != theirs.trace_sha256  # the worst control is not the best one
    assert mine.manifest["options"]["backend"] == {"push": "rl", "model": "mine.json"}
    sums = {name: f"sha256 {hashlib.sha256(Path(name).read_bytes()).hexdigest()}" for name in ("mine.json", "mine.npz")}
    assert mine.manifest["sources"]["model mine.json"] == sums
    assert invoke("verify", "mine")[0] == 0


def test_an_onnx_file_runs_from_the_command_line(tmp_path, some_engine, monkeypatch):
    monkeypatch.chdir(tmp_path)
    file = onnx(tmp_path)
    fields = [f"--set={name}={value}" for name, value in QUICK.items()]
    code, said = invoke("run", "sanity", *fields, "-b", some_engine, "--model", file, "-n1", "-q", "--out", "run")
    assert code == 0, said
    told = colonysim.Run.open("run").manifest["sources"]["model net.onnx"]
    assert told == {"net.onnx": f"sha256 {hashlib.sha256(file.read_bytes()).hexdigest()}"}


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["-b", "ENGINE", "--push", "rl", "--model", "none.json"], "none.json: "),
        (["-b", "ENGINE", "--push", "rl", "--model", "none.onnx"], "none.onnx: "),
        (["-b", "ENGINE", "--push", "scripted", "--model", "mine.json"], "the executor 'scripted' has no network"),
        (["-b", "ENGINE", "--push", "stagd"], "no push executor 'stagd'; did you mean 'staged'?"),
        (["-b", "ENGINE", "--push", "nowhere:Push"], "'nowhere:Push' (nowhere:Push) cannot be loaded"),
        (["--model", "mine.json"], "--model: the node world has no bodies"),
    ],
)
def test_what_does_not_fit_is_told_in_one_line(words, told, tmp_path, some_engine, monkeypatch):
    monkeypatch.chdir(tmp_path)
    own_card(tmp_path)
    code, said = invoke("run", "sanity", *[some_engine if word == "ENGINE" else word for word in words])
    assert code == 2 and said.startswith("Error: ") and told in said and said.count("\n") == 1, said
    assert not Path("runs").exists()


def stopped(folder: Path, engine: str, model: Path) -> Path:
    """A run that was interrupted after its first episode, and has a checkpoint."""

    def stop(event, run):
        if event.kind == "episode" and event.episode == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        colonysim.run(
            "sanity", backend=engine, backend_options={"push": "staged", "model": str(model)}, episodes=3, seed=1,
            overrides=QUICK, out=folder / "run", checkpoint_every=0.01, on_event=stop,
        )  # fmt: skip
    return folder / "run"


def test_a_run_is_resumed_with_its_network_and_with_no_other(tmp_path, some_engine):
    card = own_card(tmp_path)
    whole = colonysim.run(
        "sanity", backend=some_engine, backend_options={"push": "staged", "model": str(card)}, episodes=3, seed=1,
        overrides=QUICK, trace=False,
    )  # fmt: skip
    path = stopped(tmp_path, some_engine, card)
    own_card(tmp_path, scale=0.5)
    with pytest.raises(ColonysimError, match=r"mine\.json, whose file mine\.json is another one now"):
        colonysim.resume(path)
    own_card(tmp_path)
    assert colonysim.resume(path).trace_sha256 == whole.trace_sha256


def test_sweeps_take_a_network_and_notice_another_one(tmp_path, some_engine, monkeypatch):
    from colonysim.sweep.plan import load_sweep

    monkeypatch.chdir(tmp_path)
    own_card(tmp_path)
    backend = f"{{name: {some_engine}, push: rl, model: mine.json}}"
    (tmp_path / "sweep.yaml").write_text(f"scenarios: [sanity]\nbackends: [{backend}]\nseeds: [1]\n")
    [before] = load_sweep("sweep.yaml").trials
    own_card(tmp_path, scale=0.5)
    [after] = load_sweep("sweep.yaml").trials
    assert before.identity != after.identity
    assert replace(before, sources={}, identity="") == replace(after, sources={}, identity="")


OWN = """
from dataclasses import replace
from colonysim.push import WheelSpeeds, ignore, scripted_push

class Patient:
    name = "patient"
    def __call__(self, scene, robot, task, obstacles, log=ignore, seed=0):
        return self.push(scene, robot, task, obstacles, log)
    def push(self, scene, robot, task, obstacles, log):
        for _ in range(60):
            log("script", "think", 1)
            yield WheelSpeeds(0.0, 0.0)
        return (yield from scripted_push(scene, robot, task, obstacles, log))

class Lost(Patient):
    def push(self, scene, robot, task, obstacles, log):
        yield 1.0, "fast"

class Demanding(Patient):
    def __init__(self, model):
        self.model = model

class Absent:
    def __init__(self):
        raise SystemExit(3)
"""


@pytest.fixture
def own_module(tmp_path, monkeypatch):
    (tmp_path / "own_push.py").write_text(OWN)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.chdir(tmp_path)
    yield
    sys.modules.pop("own_push", None)


def pushed(engine, name, **more):
    options = {"push": name, **more.pop("options", {})}
    return colonysim.run(
        "sanity", backend=engine, backend_options=options, episodes=1, seed=1, overrides={"max_steps": 25}, **more
    )


def test_an_executor_of_ones_own_pushes_in_a_run(own_module, some_engine, tmp_path):
    run = pushed(some_engine, "own_push:Patient", out=tmp_path / "run")
    assert run.episodes[0].ended == "goal"
    assert "think" in run.table("controls")["control"].to_pylist()
    assert run.manifest["sources"]["own_push:Patient"]["own_push"].startswith("sha256 ")
    assert run.manifest["options"]["backend"] == {"push": "own_push:Patient"}


@pytest.mark.parametrize(
    ("name", "options", "told"),
    [
        ("own_push:Lost", {}, r"push executor 'own_push:Lost', robot \d: yields \(1.0, 'fast'\), expected two finite"),
        ("own_push:Absent", {}, "push executor 'own_push:Absent' cannot be made: SystemExit: 3"),
        ("own_push:Demanding", {}, "cannot be made: TypeError"),
        ("own_push:Patient", {"model": "x.json"}, "cannot be made with the model 'x.json': TypeError"),
    ],
)
def test_what_an_executor_does_wrong_is_told_in_one_line(name, options, told, own_module, some_engine):
    with pytest.raises(ColonysimError, match=told):
        pushed(some_engine, name, options=options, trace=False)


def test_no_file_has_an_executor_of_others_imported(own_module, some_engine, tmp_path):
    from colonysim.backends.physics import Physics

    options = {"push": "own_push:Patient"}
    with colonysim.Colony("sanity", backend=some_engine, backend_options=options, episodes=1, seed=1) as made:
        made.save(tmp_path / "saved.npz")
    sys.modules.pop("own_push")
    with pytest.raises(ColonysimError, match="push executor 'own_push:Patient' is code of others"):
        colonysim.Colony.load(tmp_path / "saved.npz")
    assert "own_push" not in sys.modules
    given = Physics(push="own_push:Patient", engine=some_engine)
    with colonysim.Colony.load(tmp_path / "saved.npz", backend=given) as loaded:
        assert loaded.episode == 0


def test_executors_are_listed(own_module):
    found = json.loads(invoke("backends", "--json")[1])
    assert {each["name"] for each in found if each["kind"] == "executors"} >= {"rl", "staged", "scripted"}
    assert all(not each["problem"] for each in found if each["kind"] == "executors")
