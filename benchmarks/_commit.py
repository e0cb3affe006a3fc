"""Which commit a generated page is of."""

import subprocess
from pathlib import Path


def commit() -> str:
    """Return the checkout's commit, with a word where files differ from it."""
    command = ["git", "describe", "--always", "--abbrev=7", "--dirty= and changes", "--exclude=*"]
    done = subprocess.run(command, cwd=Path(__file__).parent, capture_output=True, text=True, check=False)
    return done.stdout.strip() or "an unknown commit"
