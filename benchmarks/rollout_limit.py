"""Does giving long roll-outs up cost success? Each model as it is, and with only the environment's limit.

On tasks of seeds that no reported figure uses.
"""

import argparse
import json
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path


def main() -> None:
    """Evaluate both kinds of each model."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("models", type=Path, nargs="+")
    parser.add_argument("--seeds", default="50000-50009")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        for model in arguments.models:
            unlimited = Path(folder, f"{model.name}-unlimited")
            shutil.copytree(model, unlimited)
            file = json.loads((unlimited / "skills.json").read_text(encoding="utf-8"))
            for skill in file["skills"].values():
                skill["max_actions"] = None
            (unlimited / "skills.json").write_text(json.dumps(file), encoding="utf-8")
            for one in (model, unlimited):
                command = [
                    sys.executable,
                    "-m",
                    "bpns",
                    "evaluate",
                    one,
                    "--seeds",
                    arguments.seeds,
                    "--json",
                ]
                done = subprocess.run(list(map(str, command)), check=True, capture_output=True, text=True)
                summary = json.loads(done.stdout)["summary"]
                print(
                    f"{one.name:20} solved {summary['solved']['mean']:.1f} %, "
                    f"{summary['seconds']['mean'] * 1000:.1f} ms a task",
                    flush=True,
                )


if __name__ == "__main__":
    main()
