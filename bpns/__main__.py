"""``python -m bpns``."""

from bpns.cli.main import main

main()
