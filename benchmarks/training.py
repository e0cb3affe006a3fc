"""What one iteration of training costs, and whether batching networks into one computation would help.

Made-up data of the sizes that Cover gives with 1000 demonstrations. One thread, as in training.
"""

from time import process_time

import numpy as np
import torch

from bpns.learning.networks.losses import (
    binary_cross_entropy,
    gaussian_negative_log_likelihood,
    mean_squared_error,
)
from bpns.learning.networks.settings import Training
from bpns.learning.networks.training import fit

ITERATIONS = 1000


def main() -> None:
    """Print microseconds."""
    rng = np.random.default_rng(0)
    for name, rows, columns, heads, loss in (
        ("policy", 3000, 15, 2, mean_squared_error),
        ("generator", 1350, 10, 4, gaussian_negative_log_likelihood),
        ("discriminator", 2700, 15, 1, binary_cross_entropy),
    ):
        inputs = rng.uniform(size=(rows, columns)).astype(np.float32)
        targets = rng.integers(0, 2, (rows, heads // (2 if name == "generator" else 1))).astype(np.float32)
        start = process_time()
        fit(inputs, targets, loss, heads, Training(ITERATIONS), seed=0)
        print(f"{name:14} {rows} rows: {(process_time() - start) / ITERATIONS * 1e6:7.0f} us an iteration")
    torch.set_num_threads(1)
    for networks in (1, 2, 6):
        weights, values = torch.rand(networks, 32, 32), torch.rand(networks, 32, 2048)
        out = torch.empty(networks, 32, 2048)
        start = process_time()
        for _ in range(ITERATIONS):
            torch.bmm(weights, values, out=out)
        batched = (process_time() - start) / ITERATIONS * 1e6
        start = process_time()
        for _ in range(ITERATIONS):
            for network in range(networks):
                torch.mm(weights[network], values[network], out=out[network])
        single = (process_time() - start) / ITERATIONS * 1e6
        print(f"hidden layer of {networks} networks: {batched:6.0f} us batched, {single:6.0f} us one by one")


if __name__ == "__main__":
    main()
