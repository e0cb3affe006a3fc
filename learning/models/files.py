"""A saved model is a folder: domain.pddl, skills.safetensors, skills.json, run.json. What these hold.

``domain.pddl`` is the truth for the symbolic part: a person may edit it and plan again.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from bpns.learning.graphs.reactive import GraphModel
from bpns.learning.graphs.saved import GraphEntry
from bpns.symbolic.errors import InputError
from bpns.symbolic.files import check_output, read_json
from bpns.symbolic.operators import Domain
from bpns.symbolic.skills.environment import Environment
from bpns.symbolic.skills.skill import Skill

FORMAT = "bpns model 2"
FILES = ("domain.pddl", "skills.json", "skills.safetensors", "run.json")


def _left_out_if_none() -> Any:
    """Return a field that is written only where it says something."""
    return Field(default=None, exclude_if=lambda value: value is None)


class GivenEntry(BaseModel):
    """Which of the environment's given skills a skill uses, and the parameters that it gets."""

    model_config = ConfigDict(extra="forbid")
    skill: str
    arguments: list[str]


class SkillEntry(BaseModel):
    """What skills.json says of one skill."""

    model_config = ConfigDict(extra="forbid")
    parameters: list[tuple[str, str]]  # name, type
    subgoal: list[tuple[str, str]]  # parameter, feature: what a subgoal changes
    max_actions: int | None  # in one roll-out; null: the environment's limit alone
    segments: int  # that it was learned from
    demonstrations: int  # that these segments are of
    training: dict[str, tuple[float, int]]  # network -> best loss, iterations
    given: GivenEntry | None = None  # instead of learned networks
    pass_through: bool = False  # the sampler proposes actions, and the policy hands them on
    own: str | None = _left_out_if_none()  # MODULE:ATTRIBUTE: a user's own skill, instead of learned networks


class ModelFile(BaseModel):
    """skills.json."""

    model_config = ConfigDict(extra="forbid")
    format: str
    approach: str
    environment: str
    load: str  # how to ask for the environment: its name or MODULE:ATTRIBUTE
    seed: int
    skills: dict[str, SkillEntry]
    graph: GraphEntry | None = None  # chooses skills, or actions
    folder: str | None = _left_out_if_none()  # of modules of the user's, from the model's folder


@dataclass(frozen=True, slots=True, eq=False)
class SavedModel:
    """A model as loaded."""

    approach: str
    environment: Environment
    seed: int
    domain: Domain
    skills: Mapping[str, Skill]
    entries: Mapping[str, SkillEntry]
    graph: GraphModel | None = None
    header: str = ""  # the first comment of domain.pddl


def check_model_output(folder: Path, overwrite: bool) -> None:
    """Raise InputError where a model cannot be written; a folder with anything but a model stays as it is."""
    check_output(folder, overwrite, folder=True)
    if folder.exists():
        found = sorted(p.name for p in folder.iterdir()) if folder.is_dir() else ["a file"]
        others = [name for name in found if name not in FILES]
        if others:
            raise InputError(
                f"{folder} holds more than a model ({', '.join(others[:3])}): "
                "move that away, or give another --out"
            )


def read_model_file(folder: Path) -> ModelFile:
    """Return skills.json, checked; raise InputError where the folder is no model or incomplete."""
    if not folder.is_dir():
        raise InputError(f"no model folder {folder}: make one with 'bpns learn'")
    for name in FILES[:3]:
        if not (folder / name).is_file():
            raise InputError(f"{folder} is no complete model: {name} is missing: learn it again")
    try:
        file = ModelFile.model_validate(read_json(folder / "skills.json"))
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(map(str, first["loc"])) or "the whole file"
        raise InputError(
            f"{folder / 'skills.json'}: {place}: {first['msg']}: learn the model again"
        ) from error
    if file.format != FORMAT:
        raise InputError(
            f"{folder / 'skills.json'}: format '{file.format}' is not '{FORMAT}': learn it again"
        )
    return file


def model_folders(folder: Path, file: ModelFile) -> list[Path]:
    """Return where modules of the user's may be: beside the model as when it was written, and where then."""
    found = [] if file.folder is None else [(folder / file.folder).resolve()]
    run = read_json(folder / "run.json") if (folder / "run.json").exists() else {}
    noted = run.get("folder") if isinstance(run, Mapping) else None
    return [*found, Path(noted)] if isinstance(noted, str) else found
