"""Reading a model folder: skills out of domain.pddl, skills.json and skills.safetensors."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise, takewhile
from pathlib import Path

from safetensors import SafetensorError
from safetensors.numpy import load_file

from bpns.learning.graphs.saved import read_graph
from bpns.learning.models.binding import bind_operators, in_order
from bpns.learning.models.files import (
    GivenEntry,
    ModelFile,
    SavedModel,
    SkillEntry,
    model_folders,
    read_model_file,
)
from bpns.learning.models.own import own_skill
from bpns.learning.networks.network import Array32, Network, Scaling
from bpns.learning.networks.policies import Changing, LearnedPolicy, PassThrough
from bpns.learning.networks.samplers import LearnedSampler
from bpns.symbolic.errors import InputError
from bpns.symbolic.files import read_text
from bpns.symbolic.operators import Operator
from bpns.symbolic.pddl.read import read_domain
from bpns.symbolic.pddl.write import model_names
from bpns.symbolic.skills.environment import Environment, domain_of
from bpns.symbolic.skills.skill import Policy, Skill, never


def read_model(folder: Path, environment: Environment) -> SavedModel:
    """Load a model; raise InputError where its files do not fit each other or the environment."""
    file = read_model_file(folder)
    if file.environment != environment.name:
        raise InputError(f"{folder} was learned in '{file.environment}', not in '{environment.name}'")
    operators = _operators(folder, file, environment)
    try:
        tensors = load_file(folder / "skills.safetensors")
    except (SafetensorError, OSError) as error:
        raise InputError(
            f"{folder / 'skills.safetensors'}: broken: {error}: learn the model again"
        ) from error
    modules = model_folders(folder, file)
    skills = {
        one.name: _skill(one, file.skills[one.name], tensors, environment, folder, modules)
        for one in operators
    }
    own_domain = domain_of(environment, operators)
    graph = None
    if file.graph is not None:
        graph = read_graph(file.graph, operators, len(environment.action_low), tensors, folder)
    header = _header(folder / "domain.pddl")
    return SavedModel(file.approach, environment, file.seed, own_domain, skills, file.skills, graph, header)


def _operators(folder: Path, file: ModelFile, environment: Environment) -> tuple[Operator, ...]:
    """Return the operators of domain.pddl, which may have been edited: those that skills.json is about."""
    path = folder / "domain.pddl"
    names = model_names(domain_of(environment, ())) | {name.lower(): name for name in file.skills}
    domain = read_domain(path, names)
    if domain.name != environment.name:
        raise InputError(
            f"{path}: the domain is called '{domain.name}', not '{environment.name}': rename it, "
            "or put back the file of this model"
        )
    operators = bind_operators(domain, environment, path)
    found = [operator.name for operator in operators]
    have = ", ".join(file.skills)
    for name in found:
        if name not in file.skills:
            raise InputError(
                f"{path}: operator '{name}' has no weights (skills.json has: {have}): "
                "give it one of these names, or remove it"
            )
    for name in file.skills:
        if name not in found:
            raise InputError(
                f"{folder / 'skills.json'}: weights of '{name}' have no operator in domain.pddl: put the "
                f"operator back{'' if file.graph and name in file.graph.skills else ', or remove this entry'}"
            )
    return tuple(in_order(one, file.skills[one.name].parameters, path) for one in operators)


def _header(path: Path) -> str:
    """Return the comment that a PDDL file begins with."""
    lines = takewhile(lambda line: line.startswith(";"), read_text(path).splitlines())
    return "\n".join(line.lstrip(";").strip() for line in lines)


def _skill(
    operator: Operator,
    entry: SkillEntry,
    tensors: Mapping[str, Array32],
    environment: Environment,
    folder: Path,
    modules: Sequence[Path],
) -> Skill:
    """Put a skill together from its three files, or from a module of the user's."""
    if entry.own is not None:
        return own_skill(entry.own, operator, environment, modules)
    if entry.given is not None:
        return _given(operator, entry, entry.given, environment, folder)
    parts = _Parts(operator.name, tensors, folder / "skills.safetensors")
    changing = _changing(operator, entry, folder)
    size = sum(len(v.type.features) for v in operator.parameters) + 1
    actions = len(environment.action_low)
    dimension = actions if entry.pass_through else len(changing)
    box = environment.action_low, environment.action_high
    policy: Policy = PassThrough(*box)
    if not entry.pass_through:
        network = parts.network("policy", size + dimension, actions)
        policy = LearnedPolicy.of(changing, network, parts.scaling("policy.outputs", actions), box)
    names = [name for name in entry.training if name.startswith("generator-")]
    generators = tuple(parts.network(name, size, 2 * dimension) for name in names)
    discriminator = None
    if "discriminator" in entry.training:
        discriminator = parts.network("discriminator", size + dimension, 1)
    subgoals = parts.scaling("generator.outputs", dimension)
    sampler = LearnedSampler.of(dimension, generators, subgoals, discriminator)
    return Skill(operator, policy, sampler, never if entry.pass_through else None, entry.max_actions)


@dataclass(frozen=True, slots=True, eq=False)
class _Parts:
    """The arrays of one skill; all raise InputError for what is missing or of a wrong shape."""

    operator: str
    tensors: Mapping[str, Array32]
    path: Path

    def take(self, name: str, *shape: int) -> Array32:
        """Return an array."""
        tensor = self.tensors.get(f"{self.operator}.{name}")
        if tensor is None or tensor.shape != shape:
            what = "missing" if tensor is None else f"of shape {tensor.shape}, not {shape}"
            raise InputError(f"{self.path}: {self.operator}.{name} is {what}: learn the model again")
        return tensor

    def scaling(self, name: str, columns: int) -> Scaling:
        """Return the scaling of so many columns."""
        return Scaling(self.take(f"{name}.shift", columns), self.take(f"{name}.scale", columns))

    def network(self, part: str, columns: int, outputs: int) -> Network:
        """Return a network of so many inputs and outputs, however many layers it has."""
        prefix = f"{self.operator}.{part}."
        depth = sum(n.startswith(prefix) and n.endswith(".weights") for n in self.tensors)
        widths = [len(self.tensors.get(f"{prefix}{i}.biases", ())) for i in range(depth)]
        layers = tuple(
            (self.take(f"{part}.{i}.weights", b, a), self.take(f"{part}.{i}.biases", b))
            for i, (a, b) in enumerate(pairwise([columns, *widths[:-1], outputs]))
        )
        linear = self.take(f"{part}.linear", outputs, columns) if f"{prefix}linear" in self.tensors else None
        return Network(self.scaling(f"{part}.inputs", columns), layers, linear)


def _given(
    operator: Operator, entry: SkillEntry, chosen: GivenEntry, environment: Environment, folder: Path
) -> Skill:
    """Put a skill together whose policy is given; parameters count by place, as in ``_changing``."""
    path = folder / "skills.json"
    given = next((g for g in environment.given_skills if g.name == chosen.skill), None)
    if given is None:
        have = ", ".join(g.name for g in environment.given_skills) or "none"
        raise InputError(
            f"{path}: {operator.name}: '{chosen.skill}' is no given skill of '{environment.name}' "
            f"(have: {have})"
        )
    names = [name for name, _ in entry.parameters]
    if not set(chosen.arguments) <= set(names):
        raise InputError(f"{path}: {operator.name}: arguments of {chosen.skill} are not among its parameters")
    arguments = tuple(operator.parameters[names.index(name)] for name in chosen.arguments)
    fits = len(arguments) == len(given.types)
    if not fits or not all(v.type.is_a(t) for v, t in zip(arguments, given.types, strict=True)):
        raise InputError(
            f"{path}: {operator.name}: {chosen.skill} does not take ({', '.join(chosen.arguments)})"
        )
    return Skill.of_given(operator, given, arguments)


def _changing(operator: Operator, entry: SkillEntry, folder: Path) -> Changing:
    """Return the changing features by number; parameters count by place, so that they may be renamed."""
    places = {name: place for place, (name, _) in enumerate(entry.parameters)}
    found = []
    for name, feature in entry.subgoal:
        if name not in places or feature not in operator.parameters[places[name]].type.features:
            raise InputError(f"{folder / 'skills.json'}: {operator.name}: no feature {name}.{feature}")
        place = places[name]
        found.append((place, operator.parameters[place].type.features.index(feature)))
    return tuple(found)
