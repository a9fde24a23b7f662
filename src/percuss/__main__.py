"""``python -m percuss`` is the command ``percuss``."""

from __future__ import annotations

import sys

from percuss.cli import main

if __name__ == "__main__":
    sys.exit(main())
