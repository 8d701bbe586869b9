"""Headless Chromium, if installed, for tests of web pages."""

import importlib.util
import shutil

import pytest

FLAGS = """
headless no-sandbox disable-gpu disable-quic no-first-run disable-background-networking disable-component-update
disable-sync disable-dev-shm-usage hide-scrollbars force-device-scale-factor=1
"""


PROGRAMS = {name: shutil.which(name) for name in ("chromium", "chromedriver")}
MISSING = [name for name, path in PROGRAMS.items() if path is None]
MISSING += [name for name in ("selenium", "trame_pyvista") if importlib.util.find_spec(name) is None]
needs_a_browser = pytest.mark.skipif(
    bool(MISSING),
    reason=f"a page in a browser needs {', '.join(MISSING)} (Debian: chromium, chromium-driver; extras: test, trame)",
)


def new_browser(profile):
    """Start headless Chromium with an empty profile; `quit` ends it."""
    from selenium import webdriver

    options = webdriver.ChromeOptions()
    options.binary_location = PROGRAMS["chromium"]
    for flag in (*FLAGS.split(), f"user-data-dir={profile}"):
        options.add_argument(f"--{flag}")
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    return webdriver.Chrome(options=options, service=webdriver.ChromeService(PROGRAMS["chromedriver"]))
