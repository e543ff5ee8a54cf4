"""`python -m floquetrod` is the command `floquetrod`."""

import sys

from floquetrod.cli import main

if __name__ == "__main__":
    sys.exit(main())
