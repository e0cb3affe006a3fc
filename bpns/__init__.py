"""Starts the program, and in a wheel puts the four packages on the path (design: house.md, section 6)."""

import sys
from pathlib import Path

__version__ = "0.1.0"

_packages = Path(__file__).parent / "packages"
if _packages.is_dir():  # only in a wheel; a checkout has the packages beside this one
    sys.path.insert(0, str(_packages))


def main() -> None:
    """Run the command line."""
    from cli.main import main as run

    sys.path.append(str(Path.cwd()))  # for environments of the user's own, given as module:attribute
    run()
