"""Where skills are from, as far as a table of results says it: from a model folder, or by hand."""

from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path

from pydantic import BaseModel, ValidationError

from bpns.learning.models.files import FILES, read_model_file
from bpns.symbolic.errors import InputError
from bpns.symbolic.files import read_json


@dataclass(frozen=True, slots=True)
class Origin:
    """What made a set of skills. None: it was not written down, or nothing was learned."""

    approach: str
    model: str  # short digest of all that a solver reads of a model folder
    learning_preset: str | None = None
    min_share: float | None = None  # of all segments, below which an operator was dropped
    demonstrations: int | None = None  # asked for
    learning_seed: int | None = None
    cpu_seconds: float | None = None  # of learning


ORACLE = Origin("oracle", "oracle")


class _Settings(BaseModel):
    min_share: float | None = None


class _Demonstrations(BaseModel):
    asked: int | None = None


class _Run(BaseModel):
    """What matters here of run.json."""

    preset: str | None = None
    cpu_seconds: float | None = None
    settings: _Settings = _Settings()
    demonstrations: _Demonstrations = _Demonstrations()


def read_origin(folder: Path) -> Origin:
    """Return a model's origin; raise InputError where the folder is no model."""
    file = read_model_file(folder)
    path = folder / "run.json"
    try:
        run = _Run.model_validate(read_json(path)) if path.exists() else _Run()
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(map(str, first["loc"])) or "the whole file"
        raise InputError(f"{path}: {place}: {first['msg']}: put it right, or learn again") from error
    return Origin(
        file.approach,
        _digest(folder, f"{run.preset} {run.settings.min_share} {run.demonstrations.asked}"),
        run.preset,
        run.settings.min_share,
        run.demonstrations.asked,
        file.seed,
        run.cpu_seconds,
    )


def _digest(folder: Path, told: str) -> str:
    """Return 16 hexadecimal digits that change with any file of a model, and with what run.json told."""
    digest = sha256(told.encode())
    for name in FILES:
        if name != "run.json" and (folder / name).exists():
            content = (folder / name).read_bytes()
            digest.update(f"{name} {len(content)}\n".encode())
            digest.update(content)
    return digest.hexdigest()[:16]
