"""Signals that are held back come at the end, none is lost."""

from __future__ import annotations

import os
import signal

import pytest

from colonysim.signals import held


@pytest.mark.skipif(not hasattr(signal, "pthread_sigmask"), reason="there are no such signals")
def test_ctrl_c_waits_for_the_end_of_the_block():
    before, came = signal.signal(signal.SIGINT, signal.default_int_handler), []
    try:
        with pytest.raises(KeyboardInterrupt), held():
            os.kill(os.getpid(), signal.SIGINT)
            came.append("the rest of the block")
    finally:
        signal.signal(signal.SIGINT, before)
    assert came == ["the rest of the block"]
