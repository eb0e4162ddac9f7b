from __future__ import annotations

from pathlib import Path

import pytest

import colonysim
from colonysim.errors import TraceError
from colonysim.trace.export import export
from colonysim.trace.schema import Event


def test_run_returns_what_open_reads(tmp_path: Path) -> None:
    made = colonysim.run("sanity", seed=3, episodes=2, out=tmp_path / "run")
    opened = colonysim.Run.open(tmp_path / "run")
    assert made.episodes == opened.episodes and made.trace_sha256 == opened.trace_sha256
    assert made.field("D", episode=1) == opened.field("D", episode=1)
    assert opened.verify()
    live = list(colonysim.simulate(colonysim.load_scenario("sanity"), seed=3, episodes=2))
    assert list(opened.events()) == live


def test_a_directory_whose_name_is_no_text(tmp_path: Path) -> None:
    try:
        made = colonysim.run("sanity", episodes=1, out=tmp_path / "z\udcff")
    except TraceError as error:
        pytest.skip(f"this system has no such names: {error}")
    assert colonysim.Run.open(tmp_path / "z\udcff").verify()
    rows = export(made, "events", "parquet", tmp_path / "z\udcff.parquet")
    assert rows == made.table("events").num_rows
    # One that starts with it names it in its manifest.
    colonysim.run("sanity", episodes=1, out=tmp_path / "next", initial=made)
    assert colonysim.Run.open(tmp_path / "next").manifest["options"]["initial"].endswith("z?")


@pytest.mark.parametrize("name", ["a\0b", "a\ud800zz"])
def test_no_name_of_a_directory_is_one_error(name: str, tmp_path: Path) -> None:
    with pytest.raises(TraceError, match="cannot be made"):
        colonysim.run("sanity", episodes=1, out=tmp_path / name)
    assert list(tmp_path.iterdir()) == []


def test_scenario_path_name_and_object_run_alike(tmp_path: Path) -> None:
    from colonysim.scenario.loading import list_scenarios

    path = next(path for name, path, _, _ in list_scenarios() if name == "sanity")
    hashes = {
        colonysim.run(each, episodes=2, trace=False).trace_sha256
        for each in ("sanity", path, str(path), colonysim.load_scenario("sanity"))
    }
    assert len(hashes) == 1
    # A recorded scenario runs like the one it was recorded from.
    run = colonysim.run("hard", variant="r5-6", overrides=["max_steps=7"], episodes=1, out=tmp_path / "run")
    again = colonysim.run(colonysim.Run.open(tmp_path / "run").scenario, episodes=1, trace=False)
    assert again.trace_sha256 == run.trace_sha256


def test_an_error_or_ctrl_c_finishes_the_trace(tmp_path: Path) -> None:
    for error, status in ((KeyboardInterrupt, "interrupted"), (ZeroDivisionError, "failed")):

        def stop(event: Event, run: colonysim.Run, error: type[BaseException] = error) -> None:
            if event.episode == 3:
                raise error

        with pytest.raises(error):
            colonysim.run("sanity", out=tmp_path / status, on_event=stop)
        run = colonysim.Run.open(tmp_path / status)
        assert run.status == status and len(run.episodes) == 2 and run.verify()


def test_nothing_is_made_for_a_request_that_cannot_be_met(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(colonysim.PluginError):
        colonysim.run("sanity", policy="nobody")
    with pytest.raises(colonysim.PluginError):
        colonysim.run("sanity", backend="nothing")
    with pytest.raises(colonysim.ColonysimError):
        colonysim.run("sanity", mode="sometimes")
    assert not (tmp_path / "runs").exists()


def test_unknown_names_of_the_package_are_attribute_errors() -> None:
    with pytest.raises(AttributeError, match="simulat"):
        colonysim.simulat  # noqa: B018
    assert set(colonysim.__all__) == set(dir(colonysim))
