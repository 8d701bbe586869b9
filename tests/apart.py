"""Run code in a separate process."""

import os
import subprocess
import sys

EVALUATE = """
import numpy as np, pvphong as ph
def lit(backend, n=3):
    return ph.evaluate(np.zeros((n, 3)), np.tile([0, 0, 1.0], (n, 1)), ph.Scene([ph.DirectionalLight()]), ph.Material(),
                       backend=backend).rgb[0]
"""


def run_apart(code, *arguments, **environment):
    process = subprocess.run(
        [sys.executable, "-W", "error", "-c", code, *arguments],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
        env=os.environ | environment,
    )
    assert process.returncode == 0, process.stderr
    return process.stdout
