"""What a run, a scenario and a colony look like in a notebook, and what `view` and `plot` do outside of one."""

from __future__ import annotations

import html
import re
import webbrowser
from pathlib import Path

import pytest

import colonysim
from colonysim.errors import ColonysimError, TraceError
from colonysim.view import showing
from colonysim.view.extent import Room


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> colonysim.Run:
    return colonysim.run("easy", seed=1, episodes=12, out=tmp_path_factory.mktemp("runs") / "easy")


def test_names_are_short(run: colonysim.Run) -> None:
    assert repr(run).startswith("<Run easy on nodeworld, policy colony, seed 1: finished, 12 episodes, ")
    assert re.fullmatch(r"<episode 1: \d+ steps, success [01]\.\d\d, \w+, \d+\.\d s>", repr(run.episodes[0]))
    colony = colonysim.Colony("easy", policy="random")
    assert repr(colony.view(0)) == "<view of agent 0 from node index 2>"
    assert repr(colonysim.Colony("easy", policy="colony").fields["D"]) == "<field D: 0 values>"


def test_pictures_show_what_is_there(run: colonysim.Run) -> None:
    scenario = run.scenario._repr_html_()
    assert scenario.count("<title>agent") == 4 and scenario.count("<title>node") == 31
    shown = run._repr_html_()
    assert "<svg" in shown and "3 more" not in shown and "4 more" in shown and str(run.trace_sha256) in shown


def test_names_are_no_markup(tmp_path: Path) -> None:
    file = tmp_path / "odd.yaml"
    file.write_text(
        "name: odd\ndescription: <script>alert(1)</script>\nnodes: [[0, 0, 0], [1, 1, 0]]\nedges: {radius: 1.1}\n"
        "agents: [0]\ngoal: 1\n"
    )
    scenario = colonysim.load_scenario(file)
    assert "<script" not in scenario._repr_html_() and "&lt;script" in scenario._repr_html_()


def test_a_damaged_run_says_what_is_wrong(tmp_path: Path) -> None:
    colonysim.run("sanity", episodes=1, out=tmp_path / "run")
    for part in (tmp_path / "run" / "episodes").iterdir():
        part.write_bytes(b"")
    assert "episodes" in colonysim.Run.open(tmp_path / "run")._repr_html_()


def test_the_page_below_a_cell_is_that_of_the_command(run: colonysim.Run, tmp_path: Path) -> None:
    page = run.view(inline=True, height=400)
    frame = re.search(r'<iframe sandbox="allow-scripts allow-forms" srcdoc="([^"]*)"', page._repr_html_())
    assert frame is not None and page.path is None
    assert run.path is not None and not (run.path / "view.html").exists()
    assert html.unescape(frame[1]) == showing.write_page(run, tmp_path / "page.html").read_text(encoding="utf-8")
    with pytest.raises(ColonysimError, match="inline and out"):
        run.view(inline=True, out=tmp_path / "other.html")
    with pytest.raises(TraceError, match="no episode 13"):
        run.view(13, inline=True)


def test_a_page_that_is_too_large_is_refused_or_made_smaller(
    run: colonysim.Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(showing, "INLINE", Room(1.0, 1e6, showing._OPTION, showing._EXAMPLE))
    page = run.view(inline=True)
    assert any("it shows the last, 12. Choose others with `episodes=`" in note for note in page.notes)
    assert html.escape(page.notes[0]) in page._repr_html_()
    monkeypatch.setattr(showing, "INLINE", Room(1.0, 2.0, showing._OPTION, showing._EXAMPLE))
    with pytest.raises(TraceError, match="choose fewer with `episodes=`"):
        run.view([1, 2], inline=True)


def test_a_script_writes_the_page_and_opens_it(
    run: colonysim.Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    opened: list[str] = []
    monkeypatch.setattr(webbrowser, "open", lambda address: bool(opened.append(address)))
    page = run.view(3, out=tmp_path / "page.html")
    assert page.path == tmp_path / "page.html" and opened == [page.path.as_uri()]
    assert "no browser here: open" in capsys.readouterr().err


def test_figures_are_matplotlibs(run: colonysim.Run, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    figures = run.plot(["map", "D"], episodes=12)
    assert repr(figures) == "<2 figures: map, D>"
    figures[1].savefig(tmp_path / "d.pdf")
    with pytest.raises(ColonysimError, match="cannot draw 'mpa'; did you mean 'map'"):
        run.plot("mpa")
    with pytest.raises(ColonysimError, match="kept no trace"):
        colonysim.run("sanity", episodes=1, trace=False).plot()
