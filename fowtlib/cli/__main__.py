"""`python -m fowtlib.cli` is `fowt`."""

import sys

from fowtlib.cli.app import main

sys.exit(main())
