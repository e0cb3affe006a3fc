"""Mutate PDDL files and look for a traceback, a wait of more than a second, or a round trip that differs.

The corpus is pddl_out and the competition files and cases of tests/data. File number n of
seed s is always the same, whatever the number of processes. Offending pairs are saved as NUMBER-domain.pddl
and NUMBER-problem.pddl with NUMBER.txt, which says why. Exits with 1 where there are any.
"""

import argparse
import signal
import sys
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from functools import cache
from itertools import repeat
from pathlib import Path
from random import Random
from time import monotonic
from types import FrameType

from tests.symbolic._mutations import Files, Verdict, corpus, judge, mutated

ROOT = Path(__file__).parents[1]
BATCH = 250
HANGS = 20  # seconds after which a file is given up


@cache
def files_of_corpus() -> list[Files]:
    """Return the corpus of this machine."""
    data = ROOT / "tests" / "data"
    return corpus([ROOT / "pddl_out", data / "pddl", data / "pddl-bench", data / "pddl-cases"])


def _give_up(number: int, frame: FrameType | None) -> None:
    raise TimeoutError(f"no end after {HANGS} s")


def batch(seed: int, first: int, count: int) -> list[tuple[int, Verdict]]:
    """Make and judge some of the files."""
    signal.signal(signal.SIGALRM, _give_up)
    verdicts = []
    for number in range(first, first + count):
        files = mutated(Random(f"{seed}:{number}"), files_of_corpus())
        signal.alarm(HANGS)
        verdicts.append((number, judge(files)))
        signal.alarm(0)
    return verdicts


def save(folder: Path, seed: int, number: int, verdict: Verdict) -> None:
    """Write an offending pair and why it is one."""
    folder.mkdir(parents=True, exist_ok=True)
    files = mutated(Random(f"{seed}:{number}"), files_of_corpus())
    for name, text in (("domain.pddl", files.domain), ("problem.pddl", files.problem)):
        (folder / f"{number}-{name}").write_bytes(text.encode("utf-8", errors="surrogatepass"))
    (folder / f"{number}.txt").write_text(f"seed {seed}, number {number}: {verdict.offence}\n")


def main() -> None:
    """Run and print the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=100_000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--first", type=int, default=0, help="number of the first file")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--out", type=Path, default=Path("runs/fuzz"), help="where offending files are saved")
    arguments = parser.parse_args()
    outcomes: Counter[str] = Counter()
    offences, slowest, start = 0, 0.0, monotonic()
    end = arguments.first + arguments.count
    firsts = range(arguments.first, end, BATCH)
    counts = (min(BATCH, end - first) for first in firsts)
    with ProcessPoolExecutor(arguments.processes) as pool:
        for verdicts in pool.map(batch, repeat(arguments.seed), firsts, counts):
            for number, verdict in verdicts:
                outcomes[verdict.outcome] += 1
                slowest = max(slowest, verdict.seconds)
                if verdict.offence:
                    offences += 1
                    save(arguments.out, arguments.seed, number, verdict)
                    print(f"{number}: {verdict.offence.strip().splitlines()[-1][:200]}", flush=True)
            if sum(outcomes.values()) % (20 * BATCH) == 0:
                print(f"{sum(outcomes.values()):8} files, {monotonic() - start:6.0f} s", flush=True)
    kinds = ", ".join(f"{count} {name}" for name, count in sorted(outcomes.items()))
    print(f"{sum(outcomes.values())} files of seed {arguments.seed}: {kinds}; {offences} offences;")
    print(f"slowest {slowest:.2f} s; {monotonic() - start:.0f} s in all")
    sys.exit(1 if offences else 0)


if __name__ == "__main__":
    main()
