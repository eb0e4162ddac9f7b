"""Model files: checked against their cards, loaded without any learning library."""

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from colonysim.learning.cards import ModelError, load_model, save_model, shipped_models
from colonysim.push.feasibility import load_feasibility
from colonysim.push.network import load_network, network_ticks, random_network


@pytest.fixture
def card(tmp_path: Path) -> Path:
    network = random_network("line", (8, 8), np.random.default_rng(0))
    save_model(tmp_path / "m.npz", "q-network", network.arrays(), {"inputs": "line", "ticks": 25})
    return tmp_path / "m.json"


def test_what_is_saved_is_loaded(card: Path) -> None:
    loaded = load_network(card)
    again = random_network("line", (8, 8), np.random.default_rng(0))
    assert np.array_equal(loaded.values(np.ones(9)), again.values(np.ones(9)))
    assert network_ticks(card) == network_ticks(str(card.with_suffix(".npz"))) == 25


def test_saving_twice_gives_the_same_bytes(tmp_path: Path) -> None:
    arrays = {"a": np.arange(5), "b": np.ones((2, 2))}
    save_model(tmp_path / "one.npz", "forest", arrays, {})
    save_model(tmp_path / "two.npz", "forest", arrays, {})
    assert (tmp_path / "one.npz").read_bytes() == (tmp_path / "two.npz").read_bytes()
    assert sorted(p.name for p in tmp_path.iterdir()) == ["one.json", "one.npz", "two.json", "two.npz"]


def test_a_changed_byte_is_noticed(card: Path) -> None:
    data = card.with_suffix(".npz")
    content = bytearray(data.read_bytes())
    content[len(content) // 2] ^= 1
    data.write_bytes(content)
    with pytest.raises(ModelError, match=r"m\.npz: SHA-256 is [0-9a-f]{64}, the card says"):
        load_network(card)


def _retell(card: Path, change: Callable[[dict[str, object]], None]) -> None:
    told = json.loads(card.read_text())
    change(told)
    card.write_text(json.dumps(told))


def test_a_card_of_another_kind_or_format_is_refused(card: Path) -> None:
    with pytest.raises(ModelError, match="expected a 'forest'"):
        load_feasibility(card)
    _retell(card, lambda told: told.update(format=99))
    with pytest.raises(ModelError, match="format 99"):
        load_network(card)


def test_unknown_inputs_are_refused(card: Path) -> None:
    _retell(card, lambda told: told.update(inputs="pixels"))
    with pytest.raises(ModelError, match="inputs 'pixels' are unknown"):
        load_network(card)


@pytest.mark.parametrize(
    ("name", "array", "wanted"),
    [
        ("w0", np.full((8, 23), np.nan, dtype=np.float32), "no finite number"),
        ("w1", np.zeros((8, 9), dtype=np.float32), r"layer 1 has weights \(8, 9\)"),
        ("w0", np.zeros((8, 9), dtype=np.float32), r"expected \(n, 23\)"),
    ],
)
def test_wrong_arrays_are_refused(tmp_path: Path, name: str, array: np.ndarray, wanted: str) -> None:
    arrays = random_network("line", (8, 8), np.random.default_rng(0)).arrays()
    arrays[name] = array
    save_model(tmp_path / "m.npz", "q-network", arrays, {"inputs": "line", "ticks": 25})
    with pytest.raises(ModelError, match=wanted):
        load_network(tmp_path / "m.json")


def test_arrays_of_objects_are_never_unpickled(tmp_path: Path) -> None:
    import hashlib

    data = tmp_path / "m.npz"
    np.savez(data, allow_pickle=True, w0=np.array([{"a": 1}], dtype=object))
    digest = hashlib.sha256(data.read_bytes()).hexdigest()
    told = {"format": 1, "kind": "forest", "sha256": digest, "arrays": {"w0": [1]}}
    (tmp_path / "m.json").write_text(json.dumps(told))
    with pytest.raises(ModelError, match="no file of plain arrays"):
        load_model(tmp_path / "m.json", "forest")


def test_missing_models_are_named(tmp_path: Path) -> None:
    with pytest.raises(ModelError, match="no shipped model 'pusch'; there are"):
        load_network("pusch")
    with pytest.raises(ModelError, match=r"none\.json: no such file"):
        load_network(tmp_path / "none.json")


@pytest.mark.parametrize("name", shipped_models())
def test_shipped_models_load_and_their_cards_say_how_they_were_made(name: str) -> None:
    told = load_model(name, {"feasibility": "forest", "way": "logistic"}.get(name, "q-network")).card
    assert {"about", "how", "results", "sha256"} <= set(told)
    assert "seed" in told["how"]


def test_running_a_push_needs_neither_torch_nor_scikit_learn() -> None:
    code = (
        "import sys; from colonysim.push.executors import make_executor; make_executor('staged');"
        "from colonysim.push.feasibility import load_feasibility; load_feasibility();"
        "from colonysim.push.way import load_way_chance; load_way_chance();"
        "import colonysim.push.training.evaluation, colonysim.push.training.trainer;"
        "bad = {'torch', 'sklearn', 'pickle5', 'gymnasium'} & set(sys.modules); assert not bad, bad"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_the_shipped_estimates_were_fitted_to_the_shipped_network() -> None:
    network = load_model("push", "q-network").card["sha256"]
    for name, kind in (("feasibility", "forest"), ("way", "logistic")):
        how = load_model(name, kind).card["how"]
        assert how["network"] == network, name
