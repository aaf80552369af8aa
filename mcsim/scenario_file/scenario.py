"""A scenario: a validated base point, and the axes along which it is swept."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

from mcsim.errors import InputError
from mcsim.registry import suggest
from mcsim.scenario.axes import Axis, Value, read_axes
from mcsim.scenario.case import CaseScenario
from mcsim.scenario.document import (
    Document,
    PathKey,
    get_path,
    parse_document,
    parse_scalar,
    plain_tree,
    read_document,
    with_value,
)
from mcsim.scenario.paths import axis_advice, scalars, split_path
from mcsim.scenario.validation import validate
from mcsim.systems import SYSTEMS


@dataclass(frozen=True)
class Point:
    """One point of a sweep: its coordinates and the scenario that holds there."""

    index: int
    values: tuple[Value, ...]
    identities: tuple[str, ...]
    model: CaseScenario


@dataclass(frozen=True)
class Scenario:
    """A scenario file, read and validated; the entry of the whole street.

    Attributes
    ----------
    name : str
        Name of the results' folder: the file's name without its ending.
    document : Document
        The tree as written, with overrides applied.
    base : CaseScenario
        The scenario where no axis applies, SI inside.
    axes : tuple of Axis
        The swept paths; a single run has none.
    folder : Path
        What relative file names inside the scenario refer to.
    """

    name: str
    document: Document
    base: CaseScenario
    axes: tuple[Axis, ...]
    folder: Path

    @classmethod
    def from_yaml(
        cls, source: str | Path, overrides: Mapping[str, Any] | Sequence[str] = ()
    ) -> Scenario:
        """Read a scenario from a file, or from YAML text that holds a line break.

        ``overrides`` are ``{"sensors.rate": "200 Hz"}`` or ``["sensors.rate=200 Hz"]``.

        Raises
        ------
        InputError
            Anything wrong with it, with file, line and field.
        """
        if isinstance(source, str) and "\n" in source:
            return cls._build("scenario", parse_document(source), Path(), overrides)
        path = Path(source)
        return cls._build(path.stem, read_document(path), path.parent, overrides)

    @classmethod
    def from_dict(
        cls,
        tree: Mapping[str, Any],
        name: str = "scenario",
        folder: str | Path = ".",
        overrides: Mapping[str, Any] | Sequence[str] = (),
    ) -> Scenario:
        """A scenario from nested dictionaries that hold what a file would hold."""
        document = Document(plain_tree(dict(tree), name), name)
        return cls._build(name, document, Path(folder), overrides)

    def with_values(self, overrides: Mapping[str, Any] | Sequence[str]) -> Scenario:
        """The same scenario with some values replaced."""
        return self._build(self.name, self.document, self.folder, overrides)

    @classmethod
    def _build(
        cls,
        name: str,
        document: Document,
        folder: Path,
        overrides: Mapping[str, Any] | Sequence[str],
    ) -> Scenario:
        model = _case(document)
        document = replace(document, folder=folder)
        document = _override(document, overrides, model)
        axes = read_axes(document, model)
        for axis in axes:
            # The base point takes the first value, so that a swept path may be absent elsewhere.
            document_at_axis = get_path(document.tree, split_path(axis.path))
            if document_at_axis is None:
                path = split_path(axis.path)
                document = replace(
                    document,
                    tree=with_value(document.tree, path, axis.written(axis.values[0])),
                    overrides={**document.overrides, path: document.place(("sweep", axis.path))},
                )
        base = validate(_without_sweep(document), model)
        _check_figure(document, base, axes)
        return cls(name, document, base, axes, folder)

    @property
    def n_points(self) -> int:
        """Number of points of the sweep; 1 for a single run."""
        n = 1
        for axis in self.axes:
            n *= len(axis.values)
        return n

    @cached_property
    def points(self) -> tuple[Point, ...]:
        """All points, the last axis varying fastest.

        Raises
        ------
        InputError
            A combination of values that no scenario may have.
        """
        return tuple(self._points())

    def _points(self) -> Iterator[Point]:
        model = type(self.base)
        bare = _without_sweep(self.document)
        grid = itertools.product(*(axis.values for axis in self.axes))
        for index, values in enumerate(grid):
            tree: Any = bare.tree
            overrides: dict[PathKey, str] = {}
            for axis, value in zip(self.axes, values, strict=True):
                path = split_path(axis.path)
                tree = with_value(tree, path, axis.written(value))
                overrides[path] = (
                    f"{self.document.place(('sweep', axis.path))}: "
                    f"sweep value {axis.written(value)}"
                )
            document = replace(bare, tree=tree, overrides={**bare.overrides, **overrides})
            identities = tuple(
                axis.identity(value) for axis, value in zip(self.axes, values, strict=True)
            )
            yield Point(index, values, identities, validate(document, model))


def _case(document: Document) -> type[CaseScenario]:
    case = document.tree.get("case")
    if case is None:
        raise InputError(
            f"{document.place(())}: case: is missing; write `case: planar` "
            f"(known: {', '.join(SYSTEMS)})"
        )
    if case == "vibration":
        raise InputError(
            f"{document.place(('case',))}: case: vibration is analysed, not swept; "
            "use `mcsim vibration`"
        )
    if not isinstance(case, str) or case not in SYSTEMS:
        raise InputError(
            f'{document.place(("case",))}: case: "{case}" is not one of {", ".join(SYSTEMS)}'
            f"{suggest(str(case), SYSTEMS)}"
        )
    return SYSTEMS[case].scenario


def _without_sweep(document: Document) -> Document:
    return replace(document, tree={k: v for k, v in document.tree.items() if k != "sweep"})


def _override(
    document: Document,
    overrides: Mapping[str, Any] | Sequence[str],
    model: type[CaseScenario],
) -> Document:
    pairs = (
        [(path, plain_tree(value, f"--set {path}")) for path, value in overrides.items()]
        if isinstance(overrides, Mapping)
        else [_split_override(text) for text in overrides]
    )
    for path, value in pairs:
        option = f"--set {path}"
        keys: PathKey
        if path.startswith("sweep."):
            keys = ("sweep", path.removeprefix("sweep."))
        else:
            keys = split_path(path)
            known = {name.replace("*", "0") for name in scalars(model)}
            if keys[0] not in {
                *(k.split(".")[0] for k in known),
                "title",
                "outputs",
                "figure",
                "sweep",
            }:
                raise InputError(
                    f"{option}: the scenario has nothing of that name{suggest(path, known)}"
                )
            sweep = document.tree.get("sweep")
            if isinstance(sweep, dict) and path in sweep:
                raise InputError(
                    f"{option}: this scenario sweeps that value; override the sweep with "
                    f"--set 'sweep.{path}=[…]'"
                )
            advice = axis_advice(model, document.tree, path)
            if advice is not None:
                raise InputError(f"{option}: {advice}")
        try:
            tree = with_value(document.tree, keys, value)
        except InputError as error:
            raise InputError(f"{option}: {error}") from None
        document = replace(document, tree=tree, overrides={**document.overrides, keys: option})
    return document


def _split_override(text: str) -> tuple[str, Any]:
    path, equals, value = text.partition("=")
    if not equals or not path.strip():
        raise InputError(f'--set "{text}": write path=value, for example "sensors.rate=200 Hz"')
    return path.strip(), parse_scalar(value, f"--set {path.strip()}")


def _check_figure(document: Document, base: CaseScenario, axes: tuple[Axis, ...]) -> None:
    """What a figure names must be the case's errors and statistics, and the paths be swept."""
    named, statistics = base.figure.statistic, base.statistics()
    if named not in statistics:
        raise InputError(
            f"{document.place(('figure', 'statistic'))}: figure.statistic: "
            f"the case {base.case} has no statistic `{named}` "
            f"(it has {', '.join(statistics)}){suggest(named, statistics)}"
        )
    paths = [axis.path for axis in axes]
    numbers = [axis for axis in axes if axis.numeric and len(axis.values) > 1]
    # A sweep that was switched off leaves nothing to map.
    if base.figure.map and axes and len(numbers) < 2:
        raise InputError(
            f"{document.place(('figure', 'map'))}: figure.map: a map needs two swept numbers, "
            f"with several values each; this sweep has {len(numbers)}"
        )
    for i, panel in enumerate(base.figure.panels or ()):
        for name in panel.errors:
            if name not in base.ERRORS:
                raise InputError(
                    f"{document.place(('figure', 'panels', i, 'errors'))}: "
                    f"figure.panels.{i}.errors: the case {base.case} has no error `{name}` "
                    f"(it has {', '.join(base.ERRORS)}){suggest(name, base.ERRORS)}"
                )
        for key, path in (("x", panel.x), ("curves", panel.curves)):
            # A sweep that was switched off leaves a figure of one point.
            if paths and path is not None and path not in paths:
                raise InputError(
                    f"{document.place(('figure', 'panels', i, key))}: figure.panels.{i}.{key}: "
                    f"`{path}` is not swept here{suggest(path, paths)}"
                )
