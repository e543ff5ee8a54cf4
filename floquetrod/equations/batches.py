"""Batches of systems: made of separate ones, as flat arrays, and taken apart."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import fields
from typing import Any

import numpy as np

from floquetrod._util import validate
from floquetrod.equations.hill_system import HillSystem
from floquetrod.equations.matrices import Matrix, remade
from floquetrod.equations.periodic_system import PeriodicSystem
from floquetrod.equations.pieces import Varying

System = HillSystem | PeriodicSystem


def stack(systems: Sequence[System]) -> System:
    """Return single systems as one batch of shape (m,), in their order.

    Missing harmonics become zeros; systems in pieces must all have as many, and durations other than doubles are
    rounded.  A matrix common to all stays one matrix, to keep structure that shows in shared matrices only
    (C = 2 c M).

    Parameters
    ----------
    systems : sequence of HillSystem, or of PeriodicSystem
        At least one, all of the same order.

    Returns
    -------
    HillSystem or PeriodicSystem
        One batch; ``shape`` is (m,).

    Raises
    ------
    TypeError, ValueError
        For anything that is not a system, for systems of both kinds or of several orders, and for batches.

    Examples
    --------
    >>> stack([HillSystem([[1.0]], period=2.0), HillSystem([[1.5]], [[[0.2]]], period=2.0)]).harmonics[:, 0, 0, 0].real
    array([0. , 0.2])
    """
    if not validate.iterable(systems):
        raise TypeError(f"systems must be a sequence of systems, got {validate.short(systems)}")
    listed = validate.listed("systems", systems, validate.MOST_ELEMENTS, "systems")
    if not listed:
        raise ValueError("systems must hold at least one system, got none")
    kind = HillSystem if isinstance(listed[0], HillSystem) else PeriodicSystem
    for i, system in enumerate(listed):
        validate.instance(f"systems[{i}]", system, kind)
        if system.shape or system.order != listed[0].order:
            what = f"a batch of shape {system.shape}" if system.shape else f"one of order {system.order}"
            raise ValueError(f"systems[{i}] must be a single system of order {listed[0].order}, got {what}")
        if len(system.pieces) != len(listed[0].pieces):
            counts = f"{len(listed[0].pieces)}, got {len(system.pieces)}"
            raise ValueError(f"systems[{i}] must have as many pieces as the first, {counts}; stack them apart")
    zero = np.zeros((listed[0].order,) * 2)

    def series(name: str, members: Sequence[Any] = listed) -> list[Matrix]:
        values = [getattr(system, name) for system in members]
        longest = max(map(len, values))
        return [_merged([matrices[k] if k < len(matrices) else zero for matrices in values]) for k in range(longest)]

    def piece(j: int) -> tuple[Any, Varying]:
        durations, values = zip(*(system.pieces[j] for system in listed), strict=True)
        slope = None if all(value.slope is None for value in values) else _merged([v.slope_or_zero for v in values])
        start = _merged([value.start for value in values])
        return _merged([*map(float, durations)]), Varying(
            None, slope, series("cosines", values), series("sines", values), start=start
        )

    error = max(system.coefficient_error for system in listed)
    pieces = [piece(j) for j in range(len(listed[0].pieces))]
    if pieces and all(system == listed[0] for system in listed):  # nothing else gives the batch its shape
        duration, value = pieces[0]
        pieces[0] = duration, value.mapped(lambda mean: np.stack([mean] * len(listed)), np.asarray)
    if pieces and kind is PeriodicSystem:
        return PeriodicSystem.from_pieces(pieces, coefficient_error=error)
    period = _merged([system.period for system in listed])
    if kind is PeriodicSystem:
        mean = np.stack([system.mean for system in listed])
        return PeriodicSystem(mean, series("cosines"), series("sines"), period=period, coefficient_error=error)

    def optional(name: str, absent: Matrix) -> Matrix | None:
        values = [getattr(system, name) for system in listed]
        return None if all(m is None for m in values) else _merged([absent if m is None else m for m in values])

    others = {
        "mass": optional("mass", np.eye(listed[0].order)),
        "damping": optional("damping", zero),
        "gyroscopic": optional("gyroscopic", zero),
        "coefficient_error": error,
    }
    if pieces:
        return HillSystem.from_pieces(pieces, **others)
    stiffness = np.stack([system.stiffness for system in listed])
    return HillSystem(stiffness, series("cosines"), series("sines"), period=period, **others)


def pick(systems: System, index: int) -> System:
    """Return one system of a batch by its index in C order; its matrices are not checked again."""
    if not systems.shape:
        return systems
    index_of = np.unravel_index(index, systems.shape)

    def picked(value: Any, tail: int = 2) -> Any:
        if isinstance(value, tuple):
            return tuple(map(picked, value))
        if isinstance(value, Varying):
            return remade(value, **{name: picked(matrix) for name, matrix in vars(value).items()})
        if not isinstance(value, np.ndarray):
            return value  # one for all
        inner = value.shape[value.ndim - tail :]
        return np.broadcast_to(value, (*systems.shape, *inner))[index_of].copy()

    values = {field.name: picked(getattr(systems, field.name)) for field in fields(systems) if field.name != "pieces"}
    values["period"] = float(picked(systems.period, 0))
    values["pieces"] = tuple((float(picked(duration, 0)), picked(value)) for duration, value in systems.pieces)
    for name, absent in (("mass", np.eye(systems.order)), ("damping", 0.0), ("gyroscopic", 0.0)):
        if values.get(name) is not None and (values[name] == absent).all():
            values[name] = None
    system: System = remade(systems, **values)
    return system


def in_batches(systems: Sequence[System], call: Callable[[System], Sequence[Any]]) -> list[tuple[Any, ...]]:
    """Return the results of ``call`` for every system, called once for all systems of one kind, order and structure.

    Parameters
    ----------
    systems : sequence of HillSystem or PeriodicSystem
        Single systems of any kinds and orders.
    call : callable (batch) -> sequence of arrays
        Each array has one entry for each system of the batch.
    """
    groups: dict[Any, list[int]] = {}
    for i, system in enumerate(systems):
        damping = system.uniform_damping if isinstance(system, HillSystem) else None
        kind = type(system), system.order, system.structure, damping, len(system.pieces)
        groups.setdefault((*kind, isinstance(system, PeriodicSystem) and system.is_complex), []).append(i)
    answers: list[tuple[Any, ...]] = [()] * len(systems)
    for members in groups.values():
        columns = call(stack([systems[i] for i in members]))
        for i, answer in zip(members, zip(*columns, strict=True), strict=True):
            answers[i] = answer
    return answers


def _merged(values: Sequence[Any]) -> Any:
    """Return arrays, or numbers, stacked; a single one where all are equal."""
    first = values[0]
    return first if all(np.array_equal(first, value) for value in values[1:]) else np.stack(values)
