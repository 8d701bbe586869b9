"""Time budgets count processor time, which other processes do not affect; the kernel is loaded in advance."""

import time

import numpy as np
import pytest

import pvphong as ph
from pvphong.shading import kernel
from pvphong.studies.accuracy import timing


@pytest.fixture(scope="session", autouse=True)
def _processor_time():
    if kernel.is_available():
        some = np.eye(3, dtype=np.float32)
        for precision in ("float32", "float64"):
            ph.evaluate(some, some, ph.Scene(), ph.Material(), backend="numba", precision=precision)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(timing, "perf_counter", time.process_time)
        yield
