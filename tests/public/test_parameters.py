"""Records of parameters: every field has one, what Python needs agrees with it, and nothing is ignored in silence."""

from __future__ import annotations

import dataclasses
import functools
import inspect
import math
import re
import runpy
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import floquetrod as fr
from floquetrod._util.suggest import short
from floquetrod.cli.check import rod_file_in_words
from floquetrod.cli.main import main
from floquetrod.ensembles.varied_axes import names_of
from floquetrod.equations import MathieuAQ
from floquetrod.equations.mathieu import MATHIEU, MATHIEU_AQ
from floquetrod.milling.cutter import CUTTER, TOOL_MODE
from floquetrod.parameter import NAMES, REQUIRED, Parameter, Subsystem, require_known
from floquetrod.rod.loads.tool import TOOL
from floquetrod.rod.model import parameters
from floquetrod.rod.model.wellhead import WELLHEAD, Wellhead
from floquetrod.units import units_of
from tests.conftest import needs_jit
from tests.inside import GIVEN, INSTEAD, LOAD, NUMBERS, ROD, RodBox

TABLES: dict[type, Mapping[str, Parameter]] = {
    fr.Rod: ROD,
    fr.AxialLoad: {name: LOAD[name] for name in LOAD if name not in ("far_end", "axial_damping")},
    fr.AxialWave: LOAD,
    fr.VibrationTool: TOOL,
    Wellhead: WELLHEAD,
    fr.Milling: CUTTER,
    fr.ToolMode: TOOL_MODE,
    fr.Mathieu: MATHIEU,
    MathieuAQ: MATHIEU_AQ,
}
EVERY = [(kind, name) for kind, table in TABLES.items() for name in table]


@pytest.mark.parametrize("kind", TABLES)
def test_every_field_has_a_record_and_every_record_a_field(kind: type) -> None:
    assert sorted(TABLES[kind]) == sorted(field.name for field in dataclasses.fields(kind))


@pytest.mark.parametrize(("kind", "name"), EVERY)
def test_a_record_agrees_with_field_and_argument(kind: type, name: str) -> None:
    record = TABLES[kind][name]
    arguments = inspect.signature(kind).parameters
    field = next(field for field in dataclasses.fields(kind) if field.name == name)
    assert {name, *(alias.name for alias in record.instead)} - {"bore"} <= arguments.keys()
    default = arguments[name].default
    given_otherwise = {"inner_radius", "inclination", "curvature"}  # None where they are not given
    if record.default is REQUIRED:
        assert default in (inspect.Parameter.empty, None)
        assert field.default is dataclasses.MISSING
    else:
        assert default == (None if kind is fr.Rod and name in given_otherwise else record.default)
        assert kind in (fr.Milling,) or field.default == record.default
    assert not record.kind or units_of(record.kind)
    assert record.least <= record.largest


@pytest.mark.parametrize(("kind", "name"), EVERY)
def test_every_parameter_is_in_the_docstring(kind: type, name: str) -> None:
    listed = re.findall(r"^ {4}(\w+(?:, \w+)*) : ", str(inspect.getdoc(kind) and kind.__doc__), re.MULTILINE)
    assert name in {word for words in listed for word in words.split(", ")}


def test_every_argument_of_a_rod_has_a_record() -> None:
    assert {*inspect.signature(fr.Rod).parameters} == {*ROD, *INSTEAD}


def test_options_of_the_terminal_follow(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["check", "--help-all"])
    text = " ".join(capsys.readouterr().out.split())
    for name, record in {**GIVEN, **LOAD}.items():
        if record.option is not None:
            assert f"--{(record.option.name or name).replace('_', '-')}" in text
            assert record.option.help.format(range="").replace("%%", "%") in text


def test_the_reference_lists_every_parameter_with_its_default_and_option() -> None:
    described = runpy.run_path(str(Path(__file__).parents[2] / "docs/parameter_list.py"))
    for kind, table in {"rod": ROD, "load": LOAD, "tool": TOOL}.items():
        text = "\n".join(described["table"](kind))
        assert re.findall(r"\* - ``(\w+)``", text) == [*table]
    gravity = described["row"](ROD["gravity"])
    assert gravity[:5] == ["``gravity``", "g", "m/s2", "``9.81``", "1e-12 to 1e+15"]
    assert described["row"](ROD["depth"])[5:] == [
        "``--depth``",
        ", ".join(n for n in NAMES if n != "strings"),
        "strings",
    ]


def test_the_help_of_rod_files_names_every_key() -> None:
    text = rod_file_in_words()
    assert all(re.search(rf"\b{name}\b", text) for name in (*ROD, *INSTEAD))
    assert max(map(len, text.splitlines())) < 120


def test_what_simulations_do_not_know_an_ensemble_may_not_vary(monkeypatch: pytest.MonkeyPatch) -> None:
    problem = fr.SimulationProblem(PIPE, PUSH, duration=1e-3, segments=60, frames=2)
    assert {*names_of(problem)["rod"]} == {*NUMBERS, *INSTEAD} - {"residual_curvature"}
    with pytest.raises(ValueError, match=r"over must name what can be varied.*got 'residual_curvature'"):
        fr.ensemble(problem, over={"residual_curvature": [0.1, 0.2]})
    unknown = dataclasses.replace(ROD["radius"], known_to=frozenset(NAMES) - {"simulation"})
    monkeypatch.setitem(ROD, "radius", unknown)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=r"over must name what can be varied.*got 'diameter'"):
        fr.ensemble(problem, over={"diameter": [1e-3, 2e-3]})


# --- which subsystems know a parameter ---

WELL = fr.WellPath([0.0, 1000.0, 1450.0, 3000.0], ["0deg", "0deg", "90deg", "90deg"])
PIPE = fr.Rod.nitinol().replace(inner_radius=0.4e-3, damping_rate=0.05)
PUSH = fr.AxialLoad(mean=0.7, amplitude=0.6, frequency=60.0)
ALTERED: dict[str, Any] = {
    "inclination": 1.0,
    "ends": "clamped",
    "curvature": 2e-3,
    "path": {"path": WELL, "depth": 1100.0},
    "depth": {"path": WELL, "depth": 1200.0},
    "yield_strength": 600e6,
    "residual_curvature": 2.0,
    "natural_shape": {3: 1e-4},
    "sections": [fr.Section(radius=8e-4, length=0.5), fr.Section(radius=1e-3, length=0.7)],
    "bores": [(0.0, 9.4e-3), (0.4, 12e-3)],
}


def altered(rod: fr.Rod, name: str) -> fr.Rod:
    """Return a rod with one parameter changed: as listed, else by some percent or from zero."""
    if name in ("path", "depth"):
        return rod.replace(**ALTERED[name])
    value = getattr(rod, name)
    return rod.replace(**{name: ALTERED[name] if name in ALTERED else 1.03 * value if value else 500.0})


def bent(rod: fr.Rod) -> fr.Rod:
    """Return a rod in a channel that bends."""
    return rod if rod.curvature or rod.path is not None else rod.replace(curvature=1e-3)


def simulated(rod: fr.Rod) -> Any:
    """Return the numbers that a simulation of a rod computes with."""
    problem = fr.SimulationProblem(rod, PUSH, duration=1e-3, segments=60, frames=2)
    return str(problem.mesh.physics(problem.driving, 1e-6))


ANSWERS: dict[Subsystem, Callable[[fr.Rod], Any]] = {
    "modes": lambda rod: rod.stability(PUSH).growth_rate,
    "bends": lambda rod: bent(rod).stability(PUSH).growth_rate,
    "proofs": lambda rod: RodBox.of(rod, PUSH, (0.3, 0.4), 0.2, 20.0, None).mode_box(),
    "large motion": lambda rod: rod.steady_motion(PUSH).amplitude,
    "kicks": lambda rod: rod.critical_kick(PUSH, friction=0.1),
    "stress": lambda rod: (bent(rod).stress(PUSH).largest, rod.stress(PUSH).share_of_yield),
    "critical force": lambda rod: (rod.critical_force, rod.critical_mode),
    "helix": lambda rod: rod.critical_forces,
    "strings": lambda rod: rod.mean_force(WELL, 0.1, bottom=600.0, far_force=3.0).at_top,
    "simulation": simulated,
}


@pytest.mark.parametrize("subsystem", NAMES)
def test_what_a_subsystem_does_not_know_it_refuses(subsystem: Subsystem, monkeypatch: pytest.MonkeyPatch) -> None:
    """A strength, which is not the default, as a parameter that only another subsystem knew."""
    rod = PIPE.replace(yield_strength=600e6)
    other = frozenset(NAMES) - {subsystem}
    record = dataclasses.replace(ROD["yield_strength"], known_to=other, without_effect_on=frozenset())
    monkeypatch.setitem(ROD, "yield_strength", record)  # type: ignore[arg-type]
    with pytest.raises(
        ValueError, match=r"yield_strength is not part of .*got yield strength 600 MPa; .*yield_strength=None"
    ):
        ANSWERS[subsystem](rod)
    with pytest.raises(ValueError, match=re.escape(NAMES[subsystem])):
        require_known(rod, ROD, subsystem)


@pytest.mark.parametrize("course", [{"curvature": 1e-3}, {"path": WELL, "depth": 1100.0}])
def test_critical_forces_in_a_bend_ask_whether_bends_know_a_parameter(
    course: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """In a straight channel they answer."""
    straight = PIPE.replace(yield_strength=600e6)
    bent_rod = straight.replace(**course)
    unknown = dataclasses.replace(ROD["yield_strength"], without_effect_on=frozenset(NAMES) - {"bends"})
    monkeypatch.setitem(ROD, "yield_strength", unknown)  # type: ignore[arg-type]
    assert straight.critical_force > 0.0
    assert straight.critical_mode > 0.0
    for answer in (lambda: bent_rod.critical_force, lambda: bent_rod.critical_mode, lambda: bent_rod.critical_forces):
        with pytest.raises(ValueError, match=r"yield_strength is not part of verdicts in channels that bend"):
            answer()
    with pytest.raises(ValueError, match=r"yield_strength is not part of"):
        bent_rod.stability(PUSH).report({"force": "Fcr"})


@pytest.mark.filterwarnings("ignore::floquetrod.PlausibilityWarning")
def test_forces_are_not_given_by_a_critical_force_that_ignores_a_parameter() -> None:
    """A residual curvature, which verdicts do not know; strings with it are made and asked in newtons."""
    rod = PIPE.replace(residual_curvature=0.1, length=3000.0)  # so slender that a warning would name its mode
    assert rod.force_unit is None
    assert PIPE.force_unit == PIPE.critical_force
    with pytest.raises(ValueError, match=r"residual_curvature is not part of critical forces and modes"):
        rod.critical_half_wave  # noqa: B018
    assert rod.mean_force(WELL, 0.1, bottom=600.0, far_force=3.0).report()


def same(one: Any, other: Any) -> bool:
    """Return whether two answers are alike, rounding aside."""
    if isinstance(one, float) and isinstance(other, float):
        return one == other or math.isclose(one, other, rel_tol=1e-9)
    if isinstance(one, tuple):
        return len(one) == len(other) and all(map(same, one, other))
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(same(one[key], other[key]) for key in one)
    return bool(np.all(one == other)) if isinstance(one, np.ndarray) else str(one) == str(other)


@functools.cache
def unaltered(subsystem: Subsystem) -> Any:
    """Return the answer about the rod as it is."""
    return ANSWERS[subsystem](PIPE)


@needs_jit
@pytest.mark.parametrize(
    "subsystem",
    [pytest.param(name, marks=[pytest.mark.slow] * (name in ("large motion", "kicks", "strings"))) for name in NAMES],
)
@pytest.mark.parametrize("name", ROD)
@pytest.mark.filterwarnings("ignore")
def test_each_parameter_in_each_subsystem(subsystem: Subsystem, name: str) -> None:
    """It changes the answer, or is refused, or by its record has no effect."""
    require_declared(ROD[name], subsystem)


def require_declared(record: Parameter, subsystem: Subsystem) -> None:
    """Fail where a subsystem treats a changed parameter otherwise than its record says."""
    rod = altered(PIPE, record.name)
    refusal = ""
    try:
        is_same = same(ANSWERS[subsystem](rod), unaltered(subsystem))
    except ValueError as error:
        refusal = str(error)
    if refusal:  # of a known parameter because it does not go with the rest of the rod
        is_unknown = any(f"{record.name} {verb} not part of" in refusal for verb in ("is", "are"))
        assert is_unknown is (subsystem not in record.known_to), refusal
        return
    assert subsystem in record.known_to | record.without_effect_on, f"{record.name} is ignored in silence"
    if subsystem in record.without_effect_on:
        assert is_same
    elif (subsystem, record.name) not in ONLY_WITH_MORE:
        assert not is_same, short(rod)


def test_an_unknown_parameter_passes_where_refused_and_fails_where_ignored(monkeypatch: pytest.MonkeyPatch) -> None:
    """A strength as a parameter that no subsystem knew, ignored by a table that does not say so, then refused."""
    unknown = dataclasses.replace(ROD["yield_strength"], known_to=frozenset(), without_effect_on=frozenset())
    for subsystem in ("modes", "helix"):
        with pytest.raises(AssertionError, match="yield_strength is ignored in silence"):
            require_declared(unknown, subsystem)
    with monkeypatch.context() as patch:
        patch.setitem(ROD, "yield_strength", unknown)  # type: ignore[arg-type]
        require_declared(unknown, "modes")
        require_declared(unknown, "helix")
        refused_though_known = dataclasses.replace(unknown, known_to=frozenset(NAMES))
        with pytest.raises(AssertionError, match="is not part of"):
            require_declared(refused_though_known, "modes")


@pytest.mark.parametrize(
    ("subsystem", "nominal", "varied"),
    [
        ("modes", {}, {"damping_rate": (0.0, 0.4)}),
        ("modes", {}, {"length": (3.0, 3.1), "damping_rate": (0.3, 0.4)}),
        ("proofs", {}, {"damping_rate": (0.0, 0.4)}),
        ("bends", {}, {"curvature": (-1e-3, 0.0), "damping_rate": (0.0, 0.4)}),
        ("bends", {"damping_rate": 0.4}, {"curvature": (0.0, 1e-3)}),
        ("bends", {"curvature": 1e-3}, {"damping_rate": (0.0, 0.4)}),
    ],
)
def test_a_parameter_that_varies_is_refused_like_a_nominal_one(
    subsystem: Subsystem, nominal: dict[str, Any], varied: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """By samples and by boxes, also two parameters that do not go together; each alone is answered."""
    rod = fr.Rod.nitinol().replace(**nominal)
    box: dict[str, Any] = {"mean": (0.1, 0.11), "amplitude": 0.01, "frequency": 20.0}

    def answer(parameters: dict[str, Any]) -> None:
        if subsystem != "proofs":
            fr.probability_of_instability(rod, PUSH, parameters, samples=100)
        RodBox.of(rod, PUSH, *box.values(), parameters)

    answer(varied)
    unknown = dataclasses.replace(ROD["damping_rate"], known_to=frozenset(NAMES) - {subsystem})
    monkeypatch.setitem(ROD, "damping_rate", dataclasses.replace(unknown, without_effect_on=frozenset()))  # type: ignore[arg-type]
    for door in (answer, lambda parameters: RodBox.of(rod, PUSH, *box.values(), parameters)):
        with pytest.raises(ValueError, match=f"damping_rate is not part of {NAMES[subsystem]}.*got damping rate"):
            door(varied)
    known = {name: side for name, side in varied.items() if name != "damping_rate"}
    if known and not nominal:
        answer(known)


ONLY_WITH_MORE: set[tuple[str, str]] = {
    ("strings", "damping_rate"),  # of a tool's wave
    ("strings", "yield_strength"),  # of a reach
    ("stress", "gravity"),  # of an inclined rod
    ("stress", "density"),
    ("stress", "fluid_inside"),
    ("stress", "fluid_outside"),
    ("stress", "length"),
    ("stress", "inclination"),
    ("modes", "added_mass_coefficient"),  # with fluid outside
    ("bends", "added_mass_coefficient"),
    ("proofs", "added_mass_coefficient"),
    ("large motion", "added_mass_coefficient"),
    ("kicks", "added_mass_coefficient"),
    ("simulation", "added_mass_coefficient"),
    ("bends", "curvature"),  # which the question gives
}
"""Parameters that change the answer to other questions than the one asked here."""


def test_parameters_that_vary_are_numbers() -> None:
    rod = fr.Rod.nitinol()
    assert rod.parameters == {name: getattr(rod, name) for name in NUMBERS}
    assert all(isinstance(value, float) for value in rod.parameters.values())
    assert parameters.DIAMETERS.keys() < INSTEAD.keys()
