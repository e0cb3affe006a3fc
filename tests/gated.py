"""The toy world, where a process that has simulated 60 steps waits for the file named in $BPNS_TEST_GATE.

So a test can stop a program in the middle of its work, however fast or slow the machine is.
"""

import os
import time
from dataclasses import dataclass
from pathlib import Path

from bpns.symbolic.state import Array, State
from tests.toy import Toy

STEPS: list[None] = []  # of this process: an environment reaches a worker anew with each task


@dataclass(frozen=True)
class Gated(Toy):
    name: str = "gated"

    def simulate(self, state: State, action: Array) -> State:
        STEPS.append(None)
        while len(STEPS) > 60 and not Path(os.environ["BPNS_TEST_GATE"]).exists():
            time.sleep(0.01)
        return super().simulate(state, action)
