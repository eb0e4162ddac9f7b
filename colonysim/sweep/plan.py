"""What a sweep consists of: a file becomes trials, each with an identity made of all that determines its result."""

from __future__ import annotations

import hashlib
import itertools
import json
import math
import random
import warnings
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, Strict, ValidationError, model_validator

from colonysim import __version__
from colonysim.arguments import MAX_COUNT, MAX_SEED
from colonysim.errors import ColonysimError, ColonysimWarning, MissingExtraError, ScenarioError
from colonysim.geometry.robot_choice import with_robot
from colonysim.installing import install_command
from colonysim.plugins import BUILT_IN, called, load, locate, make_policy
from colonysim.provenance import TAG, parts_of, telling, unknown_in
from colonysim.scenario.contradictions import refuse_set_twice
from colonysim.scenario.loading import load_scenario, plain_data
from colonysim.scenario.places import Places
from colonysim.scenario.source import is_stream, read_file
from colonysim.suggest import nearest
from colonysim.sweep.complaints import complaint

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence

    from colonysim.provenance import Sources
    from colonysim.scenario.scenario import Scenario

__all__ = ["Limits", "Search", "Sweep", "Trial", "found", "identity", "load_search", "load_sweep", "plan_sweep"]

MAX_TRIALS = 1_000_000
"""Most trials of one sweep."""
Number = Annotated[float, Strict(), Field(allow_inf_nan=False)]
Seed = Annotated[int, Strict(), Field(ge=0, le=MAX_SEED)]


class _Section(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


def _in_order(limits: tuple[float, float]) -> tuple[float, float]:
    low, high = limits
    if not low <= high:
        raise ValueError(f"expected the lowest value first, found [{low:g}, {high:g}]")
    if not math.isfinite(high - low):
        raise ValueError(f"expected a range that is not as wide as [{low:g}, {high:g}]")
    return limits


Range = Annotated[tuple[Number, Number], AfterValidator(_in_order)]


class _Chosen(_Section):
    """A scenario with some of its variants."""

    scenario: str
    variants: Annotated[list[str | None], Field(min_length=1)] = [None]


class _Backend(BaseModel):
    """A backend with its options."""

    model_config = ConfigDict(extra="allow", frozen=True)

    name: str


class _Sample(_Section):
    """Settings drawn at random from ranges."""

    count: Annotated[int, Strict(), Field(ge=1, le=MAX_TRIALS)]
    ranges: Annotated[dict[str, Range], Field(min_length=1)]
    method: Literal["uniform", "sobol"] = "uniform"
    seed: Seed = 0


class _Seeds(_Section):
    """Seeds in a row."""

    count: Annotated[int, Strict(), Field(ge=1, le=MAX_TRIALS)]
    first: Annotated[int, Strict(), Field(ge=0, le=MAX_SEED - MAX_TRIALS)] = 0


class Limits(_Section):
    """What a trial may take; beyond that it has failed."""

    seconds: Annotated[float, Strict(), Field(gt=0, allow_inf_nan=False)] | None = None
    """Of wall clock."""
    memory_mb: Annotated[float, Strict(), Field(gt=0, allow_inf_nan=False)] | None = None
    """Of data in its process, where the system can limit that."""


class _File(_Section):
    """A sweep file."""

    name: str = "sweep"
    scenarios: Annotated[list[str | _Chosen], Field(min_length=1)]
    backends: Annotated[list[str | _Backend], Field(min_length=1)] = ["nodeworld"]
    policies: Annotated[list[str | None], Field(min_length=1)] = [None]
    modes: Annotated[list[Literal["asynchronous", "synchronous"] | None], Field(min_length=1)] = [None]
    grid: dict[str, Annotated[list[Any], Field(min_length=1)]] = {}
    sample: _Sample | None = None
    seeds: Annotated[list[Seed], Field(min_length=1)] | _Seeds = [0]
    episodes: Annotated[int, Strict(), Field(ge=1, le=MAX_COUNT)] | None = None
    limits: Limits = Limits()
    tags: dict[str, str | int | float] = {}
    """By name of a policy, field or backend: what stands for those of its changes that its source does not show."""

    @model_validator(mode="after")
    def _one_source_each(self) -> _File:
        both = sorted(set(self.grid) & set(self.sample.ranges if self.sample else ()))
        if both:
            raise ValueError(f"{both[0]!r} stands both in grid and in sample.ranges")
        return self


@dataclass(frozen=True)
class Trial:
    """One run of a sweep.

    Attributes:
        scenario: As the sweep's file names it; relative to that file.
        variant: Its variant.
        backend: Name of the backend.
        options: The backend's options.
        policy: Name of the policy; None: the scenario's own.
        mode: None: the scenario's own.
        parameters: Fields of the scenario that are set, by path.
        episodes: How many; None: the scenario's own number.
        seed: The run's seed.
        folder: What a relative path of a scenario is relative to.
        digest: Hash of the scenario's content under these settings.
        sources: What else the result depends on: third-party code, models, engines (`provenance.parts_of`), and tags.
        identity: Hash of all that determines the result: the settings, and `determinants`.
        called: The names by which tables know `policy` and `backend`, where those are others (`plugins.called`).
        start: Of a future of a run (`futures.fork_run`): its run, and `episode` and second (`at`) from which on it is
            played. The saved colony is in `folder`; `parameters` are what changes then.
        given: Of a future, policy and backend as the caller named them, if they are code of others.
    """

    scenario: str
    variant: str | None
    backend: str
    options: Mapping[str, Any]
    policy: str | None
    mode: str | None
    parameters: Mapping[str, Any]
    episodes: int | None
    seed: int
    folder: str
    digest: str = ""
    sources: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    identity: str = field(default="", compare=False)
    called: Mapping[str, str] = field(default_factory=dict, compare=False)
    start: Mapping[str, Any] = field(default_factory=dict)
    given: Mapping[str, str | None] = field(default_factory=dict)

    def asked(self) -> str:
        """Hash of what was asked, whatever the scenario's content and the code are."""
        given = {"policy": self.policy, "backend": self.backend}
        return _hash({**self.described(), **given, "episodes": self.episodes})

    def determinants(self) -> dict[str, str]:
        """What the answer depends on besides what was asked, by name."""
        modules = {f"{m} ({part})": value for part, found in self.sources.items() for m, value in found.items()}
        return {"colonysim": __version__, f"scenario {self.scenario}": self.digest[:16], **modules}

    def described(self) -> dict[str, Any]:
        """Its columns in a table, parameters by their paths."""
        options = {f"backend.{name}": value for name, value in sorted(self.options.items())}
        return {
            "scenario": self.scenario, "variant": self.variant, "backend": self.backend, "policy": self.policy,
            "mode": self.mode, **options, **self.parameters,
            **{f"fork.{name}": self.start[name] for name in ("episode", "at") if self.start},
            "seed": self.seed, **self.called,
        }  # fmt: skip

    def in_words(self) -> str:
        """Its columns for a message, such as "scenario hard, backend nodeworld, seed 3"."""
        return ", ".join(f"{name} {value}" for name, value in self.described().items() if value is not None)


@dataclass(frozen=True)
class Sweep:
    """A sweep's trials in order, and what each may take."""

    name: str
    trials: tuple[Trial, ...]
    limits: Limits


@dataclass(frozen=True)
class Search:
    """A sweep whose settings are yet to be chosen from ranges.

    Attributes:
        name: As in the file.
        ranges: Lowest and highest value of each setting, by path.
        count: How many choices to try.
        seed: Of whatever chooses.
        limits: What a trial may take.
        trials: The trials of one choice.
    """

    name: str
    ranges: Mapping[str, tuple[float, float]]
    count: int
    seed: int
    limits: Limits
    trials: Callable[[Mapping[str, float]], tuple[Trial, ...]]


def load_sweep(path: str | Path) -> Sweep:
    """Reads a sweep file.

    Every setting is tried on its scenario here, so that a misspelt parameter is found before anything runs.

    Raises:
        ScenarioError: One message: file, line, field, what is wrong.
        ColonysimError: The sweep is too large.
    """
    file, folder, places = _read(Path(path))
    return _sweep(file, folder, places)


def load_search(path: str | Path) -> Search:
    """Reads a sweep file with a `sample` whose settings something else is going to choose.

    Raises:
        ScenarioError: One message: file, line, field, what is wrong.
        ColonysimError: The sweep is too large.
    """
    file, folder, places = _read(Path(path))
    if file.sample is None:
        raise places.fault("", "has no `sample`: expected its `count` and `ranges`, from which settings are chosen")
    if file.grid:
        raise places.fault("grid", "expected no grid: a choice is judged by all of its trials together")

    # Choices of one search are made by the same code; one that finds other code later is an error.
    sources = _Sources(file.tags)

    def trials(chosen: Mapping[str, float]) -> tuple[Trial, ...]:
        return tuple(_trials(file, [dict(chosen)], folder, places, sources))

    trials({name: low for name, (low, _) in file.sample.ranges.items()})  # a misspelt setting is found at once
    return Search(file.name, file.sample.ranges, file.sample.count, file.sample.seed, file.limits, trials)


def plan_sweep(document: Mapping[str, Any]) -> Sweep:
    """The sweep that a file with these fields would describe; paths in it are relative to the current directory.

    Raises:
        ScenarioError: One message: field, what is wrong.
        ColonysimError: The sweep is too large.
    """
    places = Places("sweep", {})
    return _sweep(_checked(plain_data(document, "sweep"), places), Path(), places)


def _read(path: Path) -> tuple[_File, Path, Places]:
    document, positions = read_file(path, str(path))
    if not isinstance(document, dict):
        raise ScenarioError(f"{path}: expected fields such as `scenarios:` and `seeds:`")
    places = Places(str(path), positions)
    return _checked({"name": path.stem, **document}, places), path.parent, places


def _checked(document: Mapping[str, Any], places: Places) -> _File:
    try:
        file = _File.model_validate(document)
    except ValidationError as error:
        raise complaint(error, document, places, _fields()) from None
    _refuse_contradictions(file, places)
    return file


def _refuse_contradictions(file: _File, places: Places) -> None:
    """Refuses settings that would not hold, so that results were labelled with what was never in force."""
    given: dict[str, tuple[str, Sequence[Any]]] = {
        "policy": ("policies", file.policies), "mode": ("modes", file.modes), "episodes": ("episodes", [file.episodes]),
    }  # fmt: skip
    elsewhere = {
        path: f"`{name}:`" for path, (name, values) in given.items() if any(value is not None for value in values)
    }
    refuse_set_twice(_keys(file), elsewhere, lambda key, message: places.fault(_place(key, file), message))


def _keys(file: _File) -> list[str]:
    """Paths of the fields that are set, in that order."""
    return [*file.grid, *(file.sample.ranges if file.sample else ())]


def _place(key: str, file: _File) -> str:
    return f"grid.{key}" if key in file.grid else f"sample.ranges.{key}"


def _sweep(file: _File, folder: Path, places: Places) -> Sweep:
    return Sweep(
        file.name, tuple(_trials(file, list(_settings(file)), folder, places, _Sources(file.tags))), file.limits
    )


def _fields() -> dict[str, list[str]]:
    """The fields of a sweep file, and of its sections by their names."""
    sections: dict[str, type[BaseModel]] = {
        "": _File,
        "scenarios": _Chosen,
        "sample": _Sample,
        "seeds": _Seeds,
        "limits": Limits,
    }
    return {name: list(section.model_fields) for name, section in sections.items()}


class _Sources:
    """What trials depend on besides scenario and settings, each part looked up once."""

    def __init__(self, tags: Mapping[str, str | int | float]) -> None:
        self._tags = {name: str(tag) for name, tag in tags.items()}
        self._found: dict[str, Sources] = {}
        self.unused = set(tags)

    def of(self, trial: Trial, scenario: Scenario) -> Sources:
        """What a trial of this scenario depends on."""
        policy = trial.policy or scenario.policy
        groups = scenario.parts_of_groups
        told = [policy, trial.backend, telling(scenario.parameters), trial.options, groups]
        key = json.dumps(told, sort_keys=True, default=str)
        if key not in self._found:
            found = parts_of(policy, trial.backend, scenario.parameters, trial.options, groups)
            for name in {policy, trial.backend, *found} & self._tags.keys():
                found[name] = {**found.get(name, {}), TAG: self._tags[name]}
                self.unused.discard(name)
            for line in unknown_in(found):
                warnings.warn(
                    f"{line}; when its code changes, its trials are not run again: give it a tag in the sweep file, "
                    "such as `tags: {NAME: v1}`, and change that with the code",
                    ColonysimWarning, stacklevel=2,
                )  # fmt: skip
            self._found[key] = found
        return self._found[key]


def _trials(
    file: _File, settings: Sequence[Mapping[str, Any]], folder: Path, places: Places, sources: _Sources
) -> Iterator[Trial]:
    seeds = file.seeds if isinstance(file.seeds, list) else range(file.seeds.first, file.seeds.first + file.seeds.count)
    places_of = [
        (f"scenarios.{n}", chosen.scenario, variant)
        for n, entry in enumerate(file.scenarios)
        for chosen in [entry if isinstance(entry, _Chosen) else _Chosen(scenario=entry)]
        for variant in chosen.variants
    ]
    backends = [entry if isinstance(entry, _Backend) else _Backend(name=entry) for entry in file.backends]
    ways = list(itertools.product(backends, file.policies, file.modes))
    count = len(places_of) * len(ways) * len(settings) * len(seeds)
    if count > MAX_TRIALS:
        raise places.fault("", f"makes {count} trials, expected at most {MAX_TRIALS}")
    seen: set[str] = set()
    twins: dict[str, int] = {}
    bodies = _bodies([body.name for body in backends], places)
    for place, scenario, variant in places_of:
        for parameters in settings:
            loaded, minds = _loaded(place, scenario, variant, parameters, file, folder, places)
            for (backend, policy, mode), seed in itertools.product(ways, seeds):
                trial = Trial(
                    scenario, variant, backend.name, dict(backend.model_extra or {}), policy, mode, parameters,
                    file.episodes, seed, str(folder), loaded.digest,
                )  # fmt: skip
                names = {
                    kind: found[given]
                    for kind, found, given in (("policy", minds, policy), ("backend", bodies, backend.name))
                    if given is not None and found.get(given, given) != given
                }
                trial = replace(trial, sources=sources.of(trial, loaded), called=names)
                same = {identity(trial), _hash({**trial.described(), "content": trial.digest})}
                if not same & seen:  # listed twice, under whatever names, it is still one trial
                    yield replace(trial, identity=identity(trial))
                else:
                    named = f"{scenario} ({variant})" if variant else scenario
                    twins[named] = twins.get(named, 0) + 1
                seen |= same
    if twins:
        told = ", ".join(f"{twin} of {named}" for named, twin in twins.items())
        warnings.warn(
            f"{sum(twins.values())} of {count} trials are the same as others and run once: {told}",
            ColonysimWarning,
            stacklevel=2,
        )
    if sources.unused:
        name = min(sources.unused)
        known = [n for n in [*file.policies, *(backend.name for backend in backends)] if n is not None]
        raise places.fault(f"tags.{name}", f"no policy, field or backend {name!r} here; {nearest(name, known)}")


def _settings(file: _File) -> Iterator[dict[str, Any]]:
    drawn = list(_drawn(file.sample)) if file.sample else [{}]
    for values in itertools.product(*file.grid.values()):
        for sample in drawn:
            yield {**dict(zip(file.grid, values, strict=True)), **sample}


def _drawn(sample: _Sample) -> Iterator[dict[str, float]]:
    if sample.method == "uniform":
        rng = random.Random(sample.seed)
        shares: Sequence[Sequence[float]] = [[rng.random() for _ in sample.ranges] for _ in range(sample.count)]
    else:
        try:
            from scipy.stats import qmc
        except ImportError as error:
            raise MissingExtraError(f"Sobol samples need SciPy ({error}): {install_command('sweep')}") from error
        shares = qmc.Sobol(len(sample.ranges), rng=sample.seed).random(sample.count).tolist()
    for share in shares:
        yield {
            name: low + (high - low) * part
            for (name, (low, high)), part in zip(sample.ranges.items(), share, strict=True)
        }


def _loaded(
    place: str, scenario: str, variant: str | None, parameters: Mapping[str, Any], file: _File, folder: Path,
    places: Places,
) -> tuple[Scenario, dict[str, str]]:  # fmt: skip
    """A scenario under these settings, and what policies are called; a setting that does not fit is an error here."""
    path = found(scenario, folder)
    if is_stream(Path(path)):
        raise places.fault(place, f"{scenario}: can be read once, and each trial reads its scenario; expected a file")
    own = next((_place(key, file) for key in ("policy.name", "policy") if key in parameters), place)
    at = place
    minds: dict[str, Any] = {}
    try:
        loaded = with_robot(load_scenario(path, variant, parameters))
        for n, policy in enumerate(file.policies):
            at = own if policy is None else f"policies.{n}"
            made = make_policy(policy, loaded)
            if policy is not None:
                minds[policy] = made
    except ColonysimError as error:
        named = next((key for key in parameters if str(error).startswith(f"--set {key}=")), None)
        raise places.fault(_place(named, file) if named else at, str(error)) from None
    return loaded, _names("policies", minds)


def _bodies(backends: Sequence[str], places: Places) -> dict[str, str]:
    """What tables call backends of others; one that there is not is an error here."""
    found = {}
    for n, name in enumerate(backends):
        if name in ("physics", BUILT_IN["backends"]["physics"]):
            raise places.fault(f"backends.{n}", f"{name!r} names no engine, expected 'bullet' or 'mujoco'")
        if name not in BUILT_IN["backends"]:
            try:
                found[name] = load("backends", name)
            except ColonysimError as error:
                raise places.fault(f"backends.{n}", str(error)) from None
    return _names("backends", found)


def _names(group: str, parts: Mapping[str, Any]) -> dict[str, str]:
    """What tables call parts, by what the file calls them; those that say one name are told apart by other words."""
    names = {given: called(group, given, part) for given, part in parts.items()}
    where = {given: locate(group, given) for given in parts}
    listed = {place: name for name, place in BUILT_IN[group].items()}
    said: dict[str, set[str]] = {}
    for given, name in names.items():
        said.setdefault(name, set()).add(where[given])
    return {
        given: name if len(said[name]) == 1 else listed.get(where[given], where[given]) for given, name in names.items()
    }


def found(scenario: str, folder: str | Path) -> str | Path:
    """A scenario's name, or its path relative to the sweep's file."""
    beside = Path(folder) / scenario
    return beside if beside.suffix and not Path(scenario).is_absolute() else scenario


def identity(trial: Trial) -> str:
    """Hash of all that determines the result of a trial."""
    what = {
        "version": __version__, "scenario": trial.digest, "backend": trial.backend, "options": trial.options,
        "policy": trial.policy, "mode": trial.mode, "episodes": trial.episodes, "seed": trial.seed,
    }  # fmt: skip
    if trial.start:  # its parameters are no part of the scenario at which it begins
        what |= {"start": trial.start, "parameters": trial.parameters}
    return _hash({**what, "sources": trial.sources} if trial.sources else what)


def _hash(what: Mapping[str, Any]) -> str:
    text = json.dumps(what, sort_keys=True, separators=(",", ":"), default=str)
    return hashlib.sha256(text.encode()).hexdigest()[:16]
