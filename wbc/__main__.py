"""`python -m wbc`: the `wbc` command."""

import sys

from wbc.cli import main

if __name__ == "__main__":
    sys.exit(main())
