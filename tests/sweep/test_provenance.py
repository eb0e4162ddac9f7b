"""What a result depends on: a sweep over one's own code runs again when that changes, and says what changed."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import warnings
import zipfile
from pathlib import Path

import pytest
from test_journals import here

import colonysim
from colonysim.errors import ColonysimError, ColonysimWarning, ScenarioError
from colonysim.provenance import parts_of, sources_of, unknown_in
from colonysim.sweep import Store, load_sweep, plan_sweep, run_sweep, running, trial
from colonysim.sweep.tables import read_table
from colonysim.sweep.trial import run_trial
from colonysim.trace.manifest import read_manifest

POLICY = """
from colonysim.policies import Choice
from colonysim.world.intents import Travel, Wait
import {beside}
class Mine:
    name = "mine"
    def __init__(self, scenario): pass
    def fields(self, world): return {{}}
    def begin(self, agent, memory): return None
    def decide(self, view, memory, random):
        return Choice({beside}.intent(view), memory)
"""
STANDS = "from colonysim.world.intents import Travel, Wait\ndef intent(view):\n    return Wait((), 1.0)\n"
WALKS = STANDS.replace("Wait((), 1.0)", "Travel(view.neighbours[-1])")
LINE = "topology: {kind: line, nodes: 5}\nagents: [0]\ngoal: 4\n"
SWEEP = "scenarios: [line.yaml]\npolicies: ['%s:Mine']\nseeds: {count: 2}\nepisodes: 2\n"


@pytest.fixture
def written(tmp_path, monkeypatch):
    """Writes files to a folder that is on the path."""
    monkeypatch.syspath_prepend(tmp_path)

    def write(**files: str) -> Path:
        for name, text in files.items():
            path = tmp_path / f"{name}.py"
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)
        return tmp_path

    yield write
    for name in [name for name in sys.modules if name.startswith("own_")]:
        del sys.modules[name]


def test_a_module_with_all_that_it_imports_beside_it_and_nothing_is_run(written):
    bomb = "raise SystemExit('imported')\n"
    packages = {
        "own_p/__init__": bomb, "own_p/sub/__init__": f"from . import near\nfrom ..far import y\n{bomb}",
        "own_p/sub/near": bomb, "own_p/sub/deep": bomb, "own_p/far": bomb, "own_p/other": bomb, "own_n/m/leaf": bomb,
    }  # fmt: skip
    folder = written(
        own_a=f"import own_b, os, json, numpy.random\nfrom own_p.sub import deep\n{bomb}",
        own_b=f"def late():\n    from own_c import x\n    import importlib; importlib.import_module('own_d')\n{bomb}",
        own_c=bomb, own_d=bomb, own_unused=bomb, **packages,
    )  # fmt: skip
    found = sources_of("own_a")
    names = ["a", "b", "c", "d", "p", "p.far", "p.sub", "p.sub.deep", "p.sub.near"]
    assert list(found) == ["numpy", *(f"own_{name}" for name in names)]
    assert found["numpy"].startswith(f"{__import__('numpy').__version__} sha256 ")
    assert not [name for name in sys.modules if name.startswith("own_")]
    for name in names:
        path = folder / f"own_{name}.py".replace("p.sub.", "p/sub/").replace("p.far", "p/far")
        path = {"p": folder / "own_p/__init__.py", "p.sub": folder / "own_p/sub/__init__.py"}.get(name, path)
        before = path.read_text()
        path.write_text(f"{before}# changed\n")
        other = sources_of("own_a")
        assert {n for n in found if found[n] != other[n]} == {f"own_{name}"} and list(other) == list(found)
        path.write_text(before)
    (folder / "own_unused.py").write_text("")
    assert sources_of("own_a") == found
    assert "own_n.m.leaf" in sources_of("own_n.m.leaf"), "folders need no __init__"
    with zipfile.ZipFile(folder / "own.zip", "w") as archive:
        archive.writestr("own_zipped.py", "import own_c\n")
    sys.path.insert(0, str(folder / "own.zip"))
    assert set(sources_of("own_zipped")) == {"own_zipped", "own_c"}
    sys.path.remove(str(folder / "own.zip"))


@pytest.mark.parametrize(
    "call",
    [
        "import importlib\nimportlib.import_module(name='own_i.helper')",
        "import importlib\nimportlib.import_module('.helper', 'own_i')",
        "import importlib as il\nil.import_module('.helper', package='own_i')",
        "from importlib import import_module as im\nim('own_i.helper')",
        "import importlib\nim = importlib.import_module\nim('own_i.helper')",
        "__import__('own_i', fromlist=['helper'])",
        "import runpy\nrunpy.run_module('own_i.helper')",
        "from runpy import run_module as rm\nrm(mod_name='own_i.helper')",
        "import pkgutil\npkgutil.resolve_name('own_i.helper:K')",
        "import pkgutil\npkgutil.resolve_name('own_i.helper.K')",
    ],
)
def test_an_import_by_a_constant_is_followed_whichever_function_does_it(written, call):
    written(**{"own_i/__init__": "", "own_i/helper": "K = 1\n", "own_f": f"{call}\n"})
    assert list(sources_of("own_f")) == ["own_f", "own_i", "own_i.helper"]


def test_relative_imports_by_a_call_within_a_package(written):
    text = "import importlib\nimportlib.import_module('.helper', __package__)\n__import__('far', globals(), level=1)\n"
    written(**{"own_i/__init__": "", "own_i/helper": "", "own_i/far": "", "own_i/near": text})
    assert list(sources_of("own_i.near")) == ["own_i", "own_i.far", "own_i.helper", "own_i.near"]


@pytest.mark.parametrize(
    "call",
    [
        "import importlib\nimportlib.import_module(f'own_{1}')",
        "from importlib import import_module as im\nim('.helper', package=sys.argv[0])",
        "name = 'os'\n__import__(name)",
        "import runpy\nrunpy.run_module(*sys.argv)",
        "import runpy\nrunpy.run_path('own.py')",
        "import pkgutil\npkgutil.resolve_name(name=sys.argv[0])",
    ],
)
def test_an_import_by_another_name_is_unknown(written, monkeypatch, call):
    folder = written(own_g=f"from own_h import x\n{POLICY.format(beside='sys')}", own_h=f"import sys\nx = 1\n{call}\n")
    line = call.count("\n") + 3
    [told] = unknown_in({"own_g:Mine": sources_of("own_g")})
    assert told == f"own_g:Mine: what 'own_h' imports in line {line} shows only while it runs"
    (folder / "own_h.py").write_text("x = 1\nclass P:\n    def resolve_name(self, x): self.run_module(x)\n")
    assert unknown_in({"own_g:Mine": sources_of("own_g")}) == []


def test_one_s_own_module_that_is_called_like_one_of_python_s(written):
    folder = written(own_e="import this\n")
    assert list(sources_of("own_e")) == ["own_e"]
    (folder / "this.py").write_text("")
    assert list(sources_of("own_e")) == ["own_e", "this"]


def test_what_cannot_be_known_says_so(monkeypatch):
    main = type(sys)("__main__")
    monkeypatch.setitem(sys.modules, "__main__", main)
    assert "defined in a session" in sources_of("__main__")["__main__"]
    [line] = unknown_in(parts_of("nowhere_at_all:Policy", "nodeworld", {}))
    assert line.startswith("nowhere_at_all:Policy: module 'nowhere_at_all' has no file")
    main.__file__ = __file__
    assert sources_of("__main__")["__main__"].startswith("sha256 ")
    assert parts_of("colony", "nodeworld", {}) == {} and not any(
        unknown_in(parts_of("colony", engine, {})) for engine in ("bullet", "mujoco")
    )
    assert unknown_in({"a": {"m": "unknown: why", "tag": "1"}, "b": {"m": "unknown: why"}}) == ["b: why"]


def command(folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    path = os.pathsep.join([".", *filter(None, [os.environ.get("PYTHONPATH")])])
    answer = subprocess.run(
        [sys.executable, "-m", "colonysim", *words], cwd=folder, env={**os.environ, "PYTHONPATH": path},
        capture_output=True, text=True, timeout=100,
    )  # fmt: skip
    assert answer.returncode == 0, answer.stderr
    return answer


def test_a_sweep_over_a_policy_that_was_changed(written):
    folder = written(own_policy=POLICY.format(beside="own_beside"), own_beside=STANDS)
    (folder / "line.yaml").write_text(LINE)
    (folder / "s.yaml").write_text(SWEEP % "own_policy")

    def swept() -> tuple[str, list[float]]:
        told = command(folder, "sweep", "s.yaml", "--out", "res", "-q").stderr
        return told, [row["success"] for row in read_table(folder / "res", "trials").to_pylist()]

    assert swept() == ("", [0.0, 0.0])
    (folder / "own_beside.py").write_text(WALKS)  # the module that the policy's own imports
    told, success = swept()
    shown = command(folder, "results", "res").stdout
    assert success == [1.0, 1.0] and "1.000 [1.000, 1.000]" in shown and "0.000" not in shown
    assert told == (
        "Warning: res: changed since its trials were run: own_beside (own_policy:Mine) (2 trials); they are run again\n"
    )
    assert sorted(entry["status"] for entry in Store(folder / "res").entries.values()) == ["stale"] * 2 + [
        "succeeded"
    ] * 2
    assert swept() == ("", [1.0, 1.0]), "said once"


def swept(folder: Path, monkeypatch, **more) -> list[str]:
    """Runs s.yaml in this process; returns what was said."""
    trial._loaded.cache_clear()
    trial._sources.cache_clear()  # processes of a sweep are new ones
    monkeypatch.setattr(running, "run_locally", here)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        run_sweep(folder / "s.yaml", folder / "res", **more)
    return [str(each.message) for each in caught if each.category is ColonysimWarning]


def statuses(folder: Path) -> list[str]:
    return sorted(entry["status"] for entry in Store(folder / "res").entries.values())


FIELD = "from colonysim.pheromones import Exploration\nclass Own(Exploration):\n    name = 'own'\n    size = 1\n"
BACKEND = "from colonysim.backends.nodeworld import NodeWorld\nclass Own(NodeWorld):\n    name = 'own'\n    size = 1\n"
CHANGES = {
    "a field": ("grid: {policy.extra_fields: [['own_field:Own']]}", "own_field.py", "own_field (own_field:Own)"),
    "a backend": ("backends: ['own_backend:Own']", "own_backend.py", "own_backend (own_backend:Own)"),
    "a model": ("backends: [{name: 'own_backend:Model', model: MODEL}]", "net.npz", "net.npz (model "),
    "the scenario": ("", "line.yaml", "scenario line.yaml"),
    "timing of a variant": ("", "variant.yaml", "scenario variant.yaml"),
    "a tag": ("backends: ['own_backend:Own']\ntags: {'own_backend:Own': v1}", "s.yaml", "tag (own_backend:Own)"),
}


@pytest.mark.parametrize("kind", CHANGES)
def test_whatever_determines_the_result_is_noticed(written, monkeypatch, kind):
    text, changed, named = CHANGES[kind]
    folder = written(own_field=FIELD, own_backend=BACKEND)
    with (folder / "own_backend.py").open("a") as file:
        file.write("class Model(Own):\n    def __init__(self, model): super().__init__()\n")
    (folder / "net.json").write_text("{}")
    (folder / "net.npz").write_bytes(b"1")
    (folder / "line.yaml").write_text(LINE)
    (folder / "variant.yaml").write_text(f"{LINE}variants: {{slow: {{timing: {{travel: 2}}}}}}\n")
    scenario = "{scenario: variant.yaml, variants: [slow]}" if "variant" in kind else "line.yaml"
    text = text.replace("MODEL", json.dumps(str(folder / "net.json")))
    (folder / "s.yaml").write_text(f"scenarios: [{scenario}]\nepisodes: 1\n{text}\n")
    assert swept(folder, monkeypatch) == [] and statuses(folder) == ["succeeded"]
    assert swept(folder, monkeypatch) == [] and statuses(folder) == ["succeeded"]
    path = folder / changed
    before = path.read_bytes()
    for old, new in ((b"size = 1", b"size = 2"), (b"nodes: 5", b"nodes: 6"), (b"travel: 2", b"travel: 3")):
        path.write_bytes(path.read_bytes().replace(old, new))
    path.write_bytes(b"2" if changed == "net.npz" else path.read_bytes().replace(b"v1", b"v2"))
    assert path.read_bytes() != before
    [told] = swept(folder, monkeypatch)
    assert f"changed since its trials were run: {named}" in told and "they are run again" in told
    assert statuses(folder) == ["stale", "succeeded"]


def test_trials_that_the_file_no_longer_asks_for_are_not_shown_even_if_the_next_sweep_is_killed(written, monkeypatch):
    folder = written()
    (folder / "s.yaml").write_text("scenarios: [sanity]\nseeds: [1, 2]\nepisodes: 1\n")
    swept(folder, monkeypatch)
    (folder / "s.yaml").write_text("scenarios: [sanity]\nseeds: [2, 3]\nepisodes: 1\n")

    def killed(trials, limits, workers):
        raise SystemExit
        yield

    monkeypatch.setattr(running, "run_locally", killed)
    with monkeypatch.context() as patch, pytest.raises(SystemExit):
        patch.setattr(running, "write_tables", _first_only(running.write_tables))
        run_sweep(folder / "s.yaml", folder / "res")
    rows = read_table(folder / "res", "trials").to_pylist()
    assert [(row["seed"], row["status"]) for row in rows] == [(2, "succeeded"), (3, "pending")]
    [told] = swept(folder, monkeypatch)
    assert "1 trial in the journal that" in told and "the tables do not show" in told
    assert [row["seed"] for row in read_table(folder / "res", "trials").to_pylist()] == [2, 3]


def _first_only(write):
    calls = []

    def first(*what):
        calls.append(what)
        if len(calls) == 1:
            write(*what)

    return first


def test_code_that_changes_while_a_sweep_runs_stops_it(written, monkeypatch):
    folder = written(own_policy2=POLICY.format(beside="own_beside2"), own_beside2=WALKS)
    (folder / "line.yaml").write_text(LINE)
    (folder / "s.yaml").write_text(SWEEP % "own_policy2")
    planned = load_sweep(folder / "s.yaml").trials
    (folder / "own_beside2.py").write_text(STANDS)
    trial._sources.cache_clear()
    trial._loaded.cache_clear()
    assert run_trial(planned[0]) == {"changed": "own_beside2 (own_policy2:Mine)"}

    def another(trials, limits, workers):
        trial._loaded.cache_clear()
        (folder / "line.yaml").write_text(LINE.replace("5", "6").replace("4", "5"))
        return here(trials, limits, workers)

    monkeypatch.setattr(running, "run_locally", another)
    with pytest.raises(ColonysimError, match=r"changed since the sweep was planned: scenario line\.yaml"):
        run_sweep(folder / "s.yaml", folder / "res")
    assert statuses(folder) == ["interrupted"]


def test_code_of_a_session_is_warned_about_unless_it_has_a_tag(monkeypatch, written):
    folder = written()
    main = type(sys)("__main__")
    main.Mine = type("Mine", (colonysim.backends.nodeworld.NodeWorld,), {})
    monkeypatch.setitem(sys.modules, "__main__", main)
    text = "scenarios: [sanity]\nbackends: ['__main__:Mine']\nepisodes: 1\n"
    (folder / "s.yaml").write_text(text)
    with pytest.warns(ColonysimWarning, match=r"__main__:Mine: it is defined in a session.*give it a tag"):
        first = load_sweep(folder / "s.yaml").trials[0]
    identities = set()
    for tag in ("1", "v2", "v3"):
        (folder / "s.yaml").write_text(f"{text}tags: {{'__main__:Mine': {tag}}}\n")
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            identities.add(load_sweep(folder / "s.yaml").trials[0].identity)
    assert len({first.identity, *identities}) == 4
    (folder / "s.yaml").write_text(f"{text}tags: {{'__main__:Mein': 1}}\n")
    with pytest.raises(ScenarioError, match=r"s\.yaml:4:.*tags\.__main__:Mein: no policy.*mean '__main__:Mine'"):
        load_sweep(folder / "s.yaml")


def test_a_manifest_holds_the_sources_and_ours_are_the_version(written):
    folder = written(own_policy3=POLICY.format(beside="own_beside3"), own_beside3=WALKS)
    (folder / "line.yaml").write_text(LINE)
    run = colonysim.run(folder / "line.yaml", policy="own_policy3:Mine", episodes=1, out=folder / "run")
    sources = read_manifest(folder / "run")["sources"]
    assert sources == run.manifest["sources"] == {"own_policy3:Mine": sources_of("own_policy3")}
    from own_policy3 import Mine

    run = colonysim.run(folder / "line.yaml", policy=Mine, episodes=1, out=folder / "by-object")
    assert run.manifest["sources"] == sources
    assert colonysim.run("sanity", episodes=1, out=folder / "ours").manifest["sources"] == {}


def test_trials_of_ours_are_what_they_were():
    [planned] = plan_sweep({"scenarios": ["sanity"]}).trials
    assert planned.sources == {}
