"""`python -m cartgrasp` is `cartgrasp`."""

import sys

from .cli import main

sys.exit(main())
