"""Let tests import benchmarks from this folder, as the benchmarks do when they run as scripts."""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).parent))
