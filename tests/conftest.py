"""Being here puts `tests/` on the path, so that test modules can share code (`recorded_runs`)."""

import signal

import pytest

from colonysim.physics import ENGINES, default_engine, engine_trouble

# Where the suite runs in the background, a shell or `nohup` may have had Ctrl-C or the end of the terminal ignored; the
# tests of both, and the processes that they start, need what everybody has in front of a terminal.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)
if hasattr(signal, "SIGHUP") and signal.getsignal(signal.SIGHUP) is signal.SIG_IGN:
    signal.signal(signal.SIGHUP, signal.SIG_DFL)


@pytest.fixture(params=ENGINES)
def engine(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    """Each engine that is installed, in turn the one that is taken where none is named."""
    name: str = request.param
    if trouble := engine_trouble(name):
        pytest.skip(trouble)
    monkeypatch.setattr("colonysim.physics.engine.ENGINES", (name,))
    return name


@pytest.fixture
def some_engine() -> str:
    """The engine that is taken where none is named, for what needs one and does not depend on which."""
    name = default_engine()
    if trouble := engine_trouble(name):
        pytest.skip(trouble)
    return name


@pytest.fixture(params=["nodeworld", *ENGINES])
def backend(request: pytest.FixtureRequest) -> str:
    """The name of each backend that ships and can run here: for what must hold whatever moves the bodies."""
    name: str = request.param
    if name in ENGINES and (trouble := engine_trouble(name)):
        pytest.skip(trouble)
    return name
