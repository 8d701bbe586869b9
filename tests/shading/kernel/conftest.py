"""Skip these tests without Numba."""

from pvphong.shading import kernel

collect_ignore_glob = [] if kernel.is_available() else ["test_*.py"]
