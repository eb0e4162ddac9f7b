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
def engine(request: pytest.FixtureRequest) -> str:
    """Each rigid-body engine in turn, for what has to hold on all of them."""
    return _installed(request.param)


@pytest.fixture(scope="session")
def some_engine() -> str:
    """The rigid-body engine that is used where none is named, for what does not depend on it."""
    return _installed(default_engine())


def _installed(name: str) -> str:
    if trouble := engine_trouble(name):
        pytest.skip(trouble)
    return name
