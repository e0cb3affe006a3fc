"""Trained networks at inference: numpy only, so that planning never imports torch."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

Array32: TypeAlias = NDArray[np.float32]

Method: TypeAlias = Literal["paper", "range", "deviation"]

MIN_SCALE = np.float32(1e-3)  # columns that vary less are not stretched further: rounding errors vary, too


@dataclass(frozen=True, slots=True, eq=False)
class Scaling:
    """Maps columns to a common range: value -> (value - shift) / scale."""

    shift: Array32  # (C,)
    scale: Array32  # (C,)

    @classmethod
    def of(cls, rows: Array32, method: Method = "paper") -> "Scaling":
        """Fit a scaling to rows (B, C).

        Of the paper, spec algorithm.md section 6: shift by the minimum, scale by the range but at least by 1.
        There, features of a small range hardly differ and are learned slowly; so ``range`` is without that
        bound, and ``deviation`` gives mean 0 and standard deviation 1.
        """
        if method == "deviation":
            wide = rows.astype(np.float64)
            shift, scale = wide.mean(axis=0).astype(np.float32), wide.std(axis=0).astype(np.float32)
        else:
            shift = rows.min(axis=0)
            scale = rows.max(axis=0) - shift
        return cls(shift, np.maximum(scale, np.float32(1) if method == "paper" else MIN_SCALE))

    @classmethod
    def of_targets(cls, rows: Array32, method: Method = "paper") -> "Scaling":
        """As ``of``, but with scale 0 for columns that never vary: undone, they are exactly that constant."""
        scaling = cls.of(rows, method)
        varies = rows.max(axis=0) > rows.min(axis=0)
        shift = np.where(varies, scaling.shift, rows[0])
        return cls(shift, np.where(varies, scaling.scale, np.float32(0)))

    @property
    def varying(self) -> NDArray[np.intp]:
        """The columns whose scale is not 0."""
        return np.flatnonzero(self.scale)

    def apply(self, rows: Array32) -> Array32:
        """Return scaled rows, (..., C)."""
        return (rows - self.shift) / self.scale


@dataclass(frozen=True, slots=True, eq=False)
class Network:
    """A fully connected network with ReLU between its layers, as trained on scaled inputs."""

    inputs: Scaling
    layers: tuple[tuple[Array32, Array32], ...]  # weights (out, in) and biases (out,)
    linear: Array32 | None = None  # weights (out, in) of what is added to the last layer


def mean_of(networks: Sequence[Network]) -> Network:
    """Return one network, as much wider, whose values are the mean of alike networks' ones."""
    first, count = networks[0], len(networks)
    if count == 1:
        return first
    layers = []
    for number in range(len(first.layers)):
        weights = [network.layers[number][0] for network in networks]
        biases = [network.layers[number][1] for network in networks]
        if number == len(first.layers) - 1:  # also where it is the only one
            shared = sum(weights[1:], weights[0]) if number == 0 else np.hstack(weights)
            layers.append((shared / np.float32(count), sum(biases[1:], biases[0]) / np.float32(count)))
            continue
        if number == 0:
            stacked = np.vstack(weights)
        else:  # each sees only its own layer below
            out, below = weights[0].shape
            stacked = np.zeros((count * out, count * below), np.float32)
            for i, own in enumerate(weights):
                stacked[i * out : (i + 1) * out, i * below : (i + 1) * below] = own
        layers.append((stacked, np.concatenate(biases)))
    parts = [network.linear for network in networks if network.linear is not None]
    linear = sum(parts[1:], parts[0]) / np.float32(count) if parts else None
    return Network(first.inputs, tuple(layers), linear)


@dataclass(frozen=True, slots=True, eq=False)
class Folded:
    """A network with its scalings absorbed into the first and last layer, in float64: fast on single rows."""

    layers: tuple[tuple[NDArray[np.float64], NDArray[np.float64]], ...]  # weights (in, out), biases (out,)
    linear: NDArray[np.float64] | None = None  # weights (in, out)

    @classmethod
    def of(cls, network: Network, outputs: Scaling | None = None) -> "Folded":
        """Fold input scaling, and output scaling where the last layer's values are scaled targets."""
        layers = [(w.T.astype(np.float64), b.astype(np.float64)) for w, b in network.layers]
        weights, biases = layers[0]
        weights = weights / network.inputs.scale[:, None].astype(np.float64)
        layers[0] = weights, biases - network.inputs.shift.astype(np.float64) @ weights
        linear = None
        if network.linear is not None:
            linear = network.linear.T.astype(np.float64) / network.inputs.scale[:, None].astype(np.float64)
            weights, biases = layers[-1]
            layers[-1] = weights, biases - network.inputs.shift.astype(np.float64) @ linear
        if outputs is not None:
            weights, biases = layers[-1]
            layers[-1] = weights * outputs.scale, biases * outputs.scale + outputs.shift
            linear = None if linear is None else linear * outputs.scale
        return cls(tuple(layers), linear)

    def __call__(self, rows: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return outputs in their own units, (..., C_in) -> (..., C_out)."""
        values = rows
        for weights, biases in self.layers[:-1]:
            values = values @ weights
            values += biases
            np.maximum(values, 0.0, out=values)
        weights, biases = self.layers[-1]
        values = values @ weights + biases
        return values if self.linear is None else values + rows @ self.linear
