"""Headless Chromium, driven as a person would; from the distribution's packages chromium and chromium-driver."""

from __future__ import annotations

import json
import os
import shutil
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

REQUIRED = "COLONYSIM_BROWSER"
"""Set to "required" (as CI does), this makes a missing browser a failure instead of a skip."""
# No sandbox: there is none for root. The rest keeps the browser from looking for its own servers.
_FLAGS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--enable-unsafe-swiftshader", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync", "--hide-scrollbars",
)  # fmt: skip


@contextmanager
def chromium(width: int = 1200, height: int = 760) -> Iterator[Any]:
    """A browser; skips the test where there is none."""
    driver, browser = shutil.which("chromedriver"), shutil.which("chromium")
    try:
        from selenium import webdriver
    except ImportError:
        webdriver = None  # type: ignore[assignment]
    if not (webdriver and driver and browser):
        complaint = "no headless browser: apt-get install chromium chromium-driver; pip install selenium"
        if os.environ.get(REQUIRED) == "required":
            pytest.fail(complaint)
        pytest.skip(complaint)
    options = webdriver.ChromeOptions()
    options.binary_location = browser
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        for flag in (*_FLAGS, f"--user-data-dir={profile}", f"--window-size={width},{height}"):
            options.add_argument(flag)
        session = webdriver.Chrome(options=options, service=webdriver.ChromeService(driver))
        try:
            yield session
        finally:
            session.quit()


def show(session: Any, page: Path) -> None:
    """Opens a page and waits until it is alive."""
    session.get("about:blank")
    session.get_log("performance")
    session.get_log("browser")
    session.get(page.resolve().as_uri())
    until(lambda: session.execute_script("return Boolean(window.colonysim)"))


def until(true: Callable[[], Any], seconds: float = 30.0) -> Any:
    """Waits until something is so, and returns it."""
    begun = time.monotonic()
    while time.monotonic() - begun < seconds:
        if found := true():
            return found
        time.sleep(0.05)
    raise AssertionError(f"not so within {seconds} s")


def errors(session: Any) -> list[str]:
    """What the console has reported as wrong since the page was opened."""
    return [entry["message"] for entry in session.get_log("browser") if entry["level"] == "SEVERE"]


def requests(session: Any) -> list[str]:
    """Every address that was asked for since the page was opened."""
    messages = [json.loads(entry["message"])["message"] for entry in session.get_log("performance")]
    return [said["params"]["request"]["url"] for said in messages if said["method"] == "Network.requestWillBeSent"]
