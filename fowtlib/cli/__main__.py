"""`python -m fowtlib.cli` is `fowt`."""

import sys

from fowtlib.cli import main

sys.exit(main())
