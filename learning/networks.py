"""Trained networks at inference: numpy only, so that planning never imports torch."""

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


@dataclass(frozen=True, slots=True, eq=False)
class Folded:
    """A network with its scalings absorbed into the first and last layer, in float64: fast on single rows."""

    layers: tuple[tuple[NDArray[np.float64], NDArray[np.float64]], ...]  # weights (in, out), biases (out,)

    @classmethod
    def of(cls, network: Network, outputs: Scaling | None = None) -> "Folded":
        """Fold input scaling, and output scaling where the last layer's values are scaled targets."""
        layers = [(w.T.astype(np.float64), b.astype(np.float64)) for w, b in network.layers]
        weights, biases = layers[0]
        weights = weights / network.inputs.scale[:, None].astype(np.float64)
        layers[0] = weights, biases - network.inputs.shift.astype(np.float64) @ weights
        if outputs is not None:
            weights, biases = layers[-1]
            layers[-1] = weights * outputs.scale, biases * outputs.scale + outputs.shift
        return cls(tuple(layers))

    def __call__(self, rows: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return outputs in their own units, (..., C_in) -> (..., C_out)."""
        values = rows
        for weights, biases in self.layers[:-1]:
            values = values @ weights
            values += biases
            np.maximum(values, 0.0, out=values)
        weights, biases = self.layers[-1]
        return values @ weights + biases
