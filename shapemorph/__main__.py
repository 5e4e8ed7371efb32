"""``python -m shapemorph``."""

import sys

from shapemorph.cli.main import main

if __name__ == "__main__":
    sys.exit(main())
