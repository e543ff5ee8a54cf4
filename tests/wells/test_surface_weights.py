"""Pick-up and slack-off weights: beside an independent integration, published cases, a field case, other doors."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import floquetrod as fr
from floquetrod import cli
from tests.conftest import depth

pytestmark = pytest.mark.filterwarnings("ignore::floquetrod.PlausibilityWarning")

LBF = 4.4482216152605
PIPE = fr.Rod.catalogue("2.00x0.156 CT90", bore="4.778in", length=1.0, fluid_inside=1e3, fluid_outside=1e3)
WELL = fr.WellPath([0.0, 1000.0, 1450.0, 3000.0], ["0deg", "0deg", "90deg", "90deg"])


def direction(path: fr.WellPath, station: int) -> np.ndarray:
    """Return north, east and down of the direction at a station."""
    phi, psi = path.inclination[station], path.azimuth[station]
    return np.array([math.sin(phi) * math.cos(psi), math.sin(phi) * math.sin(psi), math.cos(phi)])


def integrated(path: fr.WellPath, mu: float, sign: float, bottom: float) -> float:
    """Return the compression in N at the upper end by SciPy's DOP853 on the vectors of the soft string.

    Along the arcs between stations, upwards: the tension T along the direction t obeys d(T t)/ds + w + n = 0, n the
    contact force across; mu abs(n) along.  A pushed string is a helix where F^2 R / (4 E I) is twice abs(n) or more.
    """
    weight = PIPE.weight_per_length * np.array([0.0, 0.0, 1.0])
    bends = PIPE.radial_clearance / (4.0 * PIPE.flexural_rigidity)
    force = 0.0
    for k in range(path.depth.size - 2, -1, -1):
        top, end = path.depth[k], path.depth[k + 1]
        if top >= bottom:
            continue
        first, last = direction(path, k), direction(path, k + 1)
        angle = math.acos(min(1.0, float(first @ last)))
        across = (last - first * math.cos(angle)) / math.sin(angle) if angle > 1e-9 else np.zeros(3)
        rate = angle / (end - top)

        def slope(
            s: float, state: np.ndarray, top: float = top, first: Any = first, across: Any = across, rate: float = rate
        ) -> list[float]:
            turned = rate * (s - top)
            along = first * math.cos(turned) + across * math.sin(turned)
            bend = rate * (across * math.cos(turned) - first * math.sin(turned))
            compression = float(state[0])
            contact = float(np.linalg.norm(weight - (weight @ along) * along - compression * bend))
            if sign > 0.0 and compression > 0.0 and bends * compression**2 >= 2.0 * contact:
                contact += bends * compression**2
            return [float(weight @ along) - sign * mu * contact]

        tight: dict[str, Any] = {"method": "DOP853", "rtol": 1e-10, "atol": 1e-6, "max_step": 5.0}
        force = float(solve_ivp(slope, (min(end, bottom), top), [force], **tight).y[0, -1])
    return force


WELLS = {
    "build": WELL,
    "three dimensions": fr.WellPath(
        [0.0, 400.0, 900.0, 1300.0, 2000.0, 2600.0],
        ["0deg", "5deg", "48deg", "62deg", "88deg", "86deg"],
        ["20deg", "20deg", "75deg", "60deg", "110deg", "140deg"],
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", [pytest.param("build", marks=pytest.mark.slow), "three dimensions"])
def test_beside_an_independent_integration(name: str) -> None:
    """To the error told and to 1e-6 of the string's weight, the tolerance of the other integration and of its helix."""
    path, depths, factors = WELLS[name], [700.0, 1200.0, 2300.0][depth(0, 1) :], [0.15, 0.3][depth(0, 1) :]
    found = PIPE.surface_weights(path, factors, depth=depths, wellhead_pressure="2000psi", stripper="3kN")
    size = PIPE.weight_per_length * 3000.0
    pressed = 2000.0 * 6894.757293168 * math.pi * PIPE.radius**2
    for k, mu in enumerate(factors):
        for i, bottom in enumerate(depths):
            up, down = (-integrated(path, mu, sign, bottom) - pressed for sign in (-1.0, 1.0))
            assert found.pick_up[k, i] == pytest.approx(up + 3e3, abs=found.error + 1e-6 * size)
            assert found.slack_off[k, i] == pytest.approx(down - 3e3, abs=found.error + 1e-6 * size)


@pytest.mark.parametrize(("inclination", "weight"), [(0.0, 7064.0), (30.0, 5235.0)])
def test_the_worked_cases_of_a_technical_note(inclination: float, weight: float) -> None:
    """5,000 ft of 1.5 in tubing run in: Newman, Bhalla & McSpadden, Basic Tubing Forces Model, CTES 2003, in lbf."""
    tubing = fr.Rod(
        "27Mpsi",
        "0.2836lb/in3",
        diameter="1.5in",
        wall_thickness="0.109in",
        length=1.0,
        channel_diameter="4in",
        fluid_inside="8.476ppg",
        fluid_outside="8.476ppg",
    )
    path = fr.WellPath.straight(length="5000ft", inclination=math.radians(inclination))
    found = tubing.surface_weights(path, 0.25, depth=["5000ft"], wellhead_pressure="1000psi", stripper="500lbf")
    snubbing = 1000.0 * 0.25 * math.pi * 1.5**2 + 500.0
    assert found.slack_off[0, 0] / LBF + snubbing == pytest.approx(weight, rel=2e-3)


# Post-frac clean-outs with 2 3/8 in tapered tubing in 5 in 21.4 lb/ft casing, Neuquen basin, published with the
# calibration of a coiled tubing simulator (github.com/demetrioalejo7-eng/Completions-Calc, tools/ct-calibration and
# src/ctsim, 2026): laterals of some 3,300 m down to 6,700 to 6,900 m, slickwater, 3,200 to 5,500 psi at the wellhead,
# stripper 4,500 lbf, friction 0.295 run in and 0.270 pulled out, fitted to 11 runs.  Known of single runs: pulled at
# 5290 to 5355 m one read 45 to 49 klbf; one with its tool jammed was stopped by incipient lock-up at 5632 m.  Surveys
# are not published: three wells that are level from some 3,500 m on stand for them.
SECTIONS = [(2370.0, 0.175), (230.0, 0.1895), (240.0, 0.214), (180.0, 0.237), (335.0, 0.263)]
SECTIONS += [(1500.0, 0.276), (435.0, 0.263), (400.0, 0.237), (1970.0, 0.224)]  # from the lower end, m and wall in in


def weight_of_tapered(path: fr.WellPath, bottom: float, mu: float, motion: str) -> float:
    """Return the weight in N above the stripper of the field's string, section after section from the lower end."""
    force, low = 0.0, bottom
    for length, wall in SECTIONS:
        up = max(path.start, low - length)
        water: dict[str, Any] = {"fluid_inside": "8.4ppg", "fluid_outside": "8.4ppg"}
        pipe = fr.Rod(
            *("27Mpsi", 7850.0),
            diameter="2.375in",
            wall_thickness=f"{wall}in",
            length=1.0,
            channel_diameter="4.126in",
            **water,
        )
        force = pipe.mean_force(path.part(up, low), mu, motion=motion, far_force=force, depth=[up]).at_top
        if math.isinf(force):
            return -math.inf
        low = up
        if low <= path.start:
            break
    return -force


@pytest.mark.parametrize(("kick_off", "build"), [(3000.0, 400.0), (3150.0, 350.0), (3200.0, 250.0)][depth(0, 2) :])
def test_a_field_case(kick_off: float, build: float) -> None:
    landing = [0.0, kick_off, kick_off + build, 6800.0]
    path = fr.WellPath(landing, ["0deg", "0deg", "90deg", "90deg"])
    pulled = weight_of_tapered(path, 5320.0, 0.270, "pulled") / LBF + 4500.0
    low, high = (pulled - psi * 0.25 * math.pi * 2.375**2 for psi in (5500.0, 3200.0))
    assert low < 45e3
    assert high > 49e3
    assert high - low < 1.1e4  # that of the range of the wellhead's pressure
    assert math.isfinite(weight_of_tapered(path, 5600.0, 0.295, "pushed"))
    assert math.isinf(weight_of_tapered(path, 5900.0, 0.295, "pushed"))


@pytest.mark.slow
def test_weights_are_those_of_the_mean_force_and_of_reach() -> None:
    given: dict[str, Any] = {"far_force": 200.0, "wellhead_pressure": "10MPa", "stripper": "4kN"}
    found = PIPE.surface_weights(WELL, [0.2, [(0, 0.3), ("1450m", 0.45)]], depth=[800.0, 1700.0, 2900.0], **given)
    for k, mu in [*enumerate((0.2, [(0, 0.3), ("1450m", 0.45)]))][depth(0, 1) :]:
        reach = PIPE.reach(WELL, mu, depth=[800.0, 1700.0, 2900.0], yield_share=None, **given)
        assert found.lock_up[k] == pytest.approx(reach.lock_up, abs=1e-6 * WELL.end)  # its accuracy
        goes = np.isfinite(found.slack_off[k])
        np.testing.assert_allclose(found.slack_off[k][goes], -reach.injector[goes], rtol=1e-6, atol=1e-2)
        for motion, weights in (("pulled", found.pick_up[k]), ("pushed", found.slack_off[k])):
            for i, bottom in [(0, 800.0), (1, 1700.0), (2, 2900.0)][depth(0, 1) :: depth(1, 2)]:
                along = PIPE.mean_force(WELL, mu, motion=motion, bottom=bottom, **given)
                weight = along.surface_weight if bottom <= found.lock_up[k] or motion == "pulled" else -math.inf
                assert weights[i] == pytest.approx(weight, rel=1e-9, abs=found.error)
    standing = PIPE.mean_force(WELL, motion="standing", **given)
    assert found.free[-1] == pytest.approx(standing.surface_weight, rel=1e-12)  # level from 1450 m on
    assert math.isinf(found.lock_up[0])
    assert math.isfinite(found.lock_up[1])


@pytest.mark.slow
def test_more_friction_spreads_the_broom() -> None:
    found = PIPE.surface_weights(WELL, [0.1, 0.2, 0.3], stripper="1kN", depth=[500.0, 1500.0, 2500.0])
    assert (np.diff(found.pick_up[:, 1:], axis=0) > 0.0).all()
    assert (np.diff(found.slack_off[:, 1:], axis=0) < 0.0).all()
    assert (found.slack_off < found.free).all()
    assert (found.free < found.pick_up).all()


@pytest.mark.slow
def test_one_factor_by_depth_is_one_and_several_are_several() -> None:
    at: dict[str, Any] = {"depth": [1100.0]}
    pairs = [(0, 0.2), ("1050m", 0.3)]
    one, wrapped = PIPE.surface_weights(WELL, pairs, **at), PIPE.surface_weights(WELL, [pairs], **at)
    assert one == wrapped
    assert PIPE.surface_weights(WELL, 0.2, **at) == PIPE.surface_weights(WELL, np.array([0.2]), **at)


@pytest.mark.parametrize("seed", range(depth(10, 1)))
def test_the_terminal_and_python_agree(seed: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rng = np.random.default_rng([50, 10, seed])
    survey = tmp_path / "survey.csv"
    survey.write_text("MD (ft),Inc (deg),Azi (deg)\n0,0,0\n3000,0,0\n4500,90,0\n6000,90,20\n", encoding="utf-8")
    first, second, below = rng.uniform(0.1, 0.5, 3).round(3).tolist()
    pressure, stripper = f"{rng.uniform(0.0, 5000.0):.1f}psi", f"{rng.uniform(0.0, 5.0):.2f}kip"
    line = ["weights", "--well", str(survey), "--rod", "2.00x0.156", "--bore", "4.778in", "--depths", "2000,5500ft"]
    line += ["--friction", f"{first},{second},{below}@3500ft", f"--wellhead-pressure={pressure}"]
    assert cli.main([*line, f"--stripper={stripper}", "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    rod = fr.Rod.catalogue("2.00x0.156", bore="4.778in", length=1000.0)
    factors = [first, [(0, second), ("3500ft", below)]]
    found = rod.surface_weights(
        fr.WellPath.from_csv(survey),
        factors,
        depth=["2000ft", "5500ft"],
        wellhead_pressure=pressure,
        stripper=stripper,
    )
    numbers = found.as_dict()
    assert {name: record[name] for name in numbers} == numbers
    rows = [(row["friction"], row["pick_up_N"]) for row in record["weights"]]
    names = [f"{first:g}", f"{second:g}, {below:g} from 1066.8 m on"]
    assert rows == list(zip(np.repeat(names, 2), found.pick_up.ravel(), strict=True))


@pytest.mark.slow
def test_what_it_says_and_draws(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    survey, picture = tmp_path / "survey.csv", tmp_path / "weights.png"
    survey.write_text("MD (ft),Inc (deg),Azi (deg)\n0,0,0\n3000,0,0\n4500,90,0\n13000,90,0\n", encoding="utf-8")
    line = ["weights", "--well", str(survey), "--rod", "2.00x0.156", "--bore", "4.778in", "--mu", "0.5"]
    assert cli.main([*line, "--depths", "12000ft", "--out", str(picture)]) == 0
    said = capsys.readouterr().out
    assert said.startswith("What does the string weigh at 12,000 ft? ")
    assert " lbf without friction; with friction 0.5: " in said
    assert " lbf picked up, slacked off it locks up at " in said
    assert "\nstring    weighs 3.077 lbf/ft in air: no fluids given\n" in said
    assert "lbf" in said
    assert "pick-up lbf, 0.5  slack-off lbf, 0.5" in said
    assert picture.stat().st_size > 10_000
    found = PIPE.surface_weights(WELL, [0.2, [(0, 0.3), (1450.0, 0.5)]], depth=[20.0, 2000.0], stripper="2kN")
    ax = found.plot(depth="ft", force="klbf")
    assert ax.get_xlabel() == "surface weight (below 0: pushed) / klbf"
    assert [text.get_text() for text in ax.get_legend().get_texts()] == [
        "without friction",
        "friction 0.2",
        "friction 0.3, 0.5 from 4757.22 ft on",
    ]
    low, high = ax.get_ylim()
    assert low > high  # downwards
    drawn = {line.get_label(): line.get_xydata() for line in ax.lines}
    np.testing.assert_allclose(drawn["friction 0.2"][:, 0], found.pick_up[0] / (1e3 * LBF), rtol=1e-12)


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"friction": []}, "friction must be 1 to 12 factors"),
        ({"friction": [0.1] * 13}, "friction must be 1 to 12 factors"),
        ({"friction": np.broadcast_to(0.2, 10**12)}, "friction must be 1 to 12 factors"),
        ({"friction": [0.2, -0.1]}, "friction must be zero or more"),
        ({"depth": [4000.0]}, "depth must lie below"),
        ({"stripper": "-1kN"}, "stripper must be zero or more"),
        ({"helical": "never"}, "helical must be one of"),
    ],
)
def test_bad_questions(wrong: dict[str, Any], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        PIPE.surface_weights(**{"path": WELL, "friction": 0.2, **wrong})
