"""How one network is trained; without torch, so that settings are made without importing it."""

from dataclasses import dataclass

from bpns.learning.networks.network import Method


@dataclass(frozen=True, slots=True)
class Training:
    """How to fit one network: at most so many iterations.

    An iteration takes all rows or, of more than ``batch`` rows, that many, in a random order that is new each
    time round. With ``decay`` the learning rate falls to zero along half a cosine. With ``held_out``, that
    share of the rows is kept apart and the loss on it decides which weights are best; otherwise the training
    loss does. ``scaling`` is of inputs and targets; see Scaling. ``patience`` is after how many iterations
    without a better loss to stop. With ``linear``, a linear part is fitted first, and the network learns what
    that leaves. ``weight_decay`` shrinks the weights at each iteration, relative to the learning rate.
    """

    iterations: int
    learning_rate: float = 1e-3
    decay: bool = False
    held_out: float = 0.0
    batch: int | None = None
    scaling: Method = "paper"
    patience: int | None = None
    hidden: tuple[int, ...] = (32, 32)
    linear: bool = False
    weight_decay: float = 0.0
