"""``python -m bpns``."""

from bpns import main

main()
