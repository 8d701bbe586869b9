"""`python -m pvphong`: the command line."""

import sys

from pvphong.cli import main

sys.exit(main())
