"""Signals that are held back come at the end, none is lost."""

from __future__ import annotations

import os
import signal
import threading
import time

import pytest

from colonysim.signals import held


@pytest.fixture(autouse=True)
def _python_s_own():
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.parametrize("threads", [0, 8])
def test_ctrl_c_waits_for_the_end_of_the_block(threads):
    """With other threads too, to which the system may give the signal."""
    done, came = threading.Event(), []
    others = [threading.Thread(target=done.wait, daemon=True) for _ in range(threads)]
    for other in others:
        other.start()
    try:
        with pytest.raises(KeyboardInterrupt), held():
            os.kill(os.getpid(), signal.SIGINT)
            time.sleep(0.05)
            came.append("the rest of the block")
    finally:
        done.set()
    assert came == ["the rest of the block"]
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_what_is_ignored_stays_ignored():
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with held():
        os.kill(os.getpid(), signal.SIGINT)
    assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN


def test_in_another_thread_nothing_is_held():
    told = []
    thread = threading.Thread(target=lambda: told.append(held().__enter__()))
    thread.start()
    thread.join()
    assert told == [None]
