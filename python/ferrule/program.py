"""The program ``ferrule`` that comes with the package."""

from __future__ import annotations

import os
import sys

#: Its file.
path: str = os.path.join(os.path.dirname(__file__), "bin", "ferrule")


def main() -> None:
    """Becomes the program, with the arguments of this process."""
    os.environ.setdefault("FERRULE_PYTHON", sys.executable)
    os.execv(path, ["ferrule", *sys.argv[1:]])
