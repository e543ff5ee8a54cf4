"""How large motion gets: `Rod.steady_motion` beside the simulator, twelve loads on four rods.

The simulated force is that of axial waves, so the same is given to both.  Each run is 16 decay times long, at twenty
segments to a half wave.

    python -m benchmarks large_motion
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import floquetrod as fr
from benchmarks.measure import Row
from floquetrod.rod.loads.load import with_waves

WIRE = fr.Rod.nitinol().replace(damping_rate=3.0)
TUBING = fr.Rod.catalogue("2.00x0.156", bore="4.778in", length=60.0, fluid_inside=1e3, fluid_outside=1e3)
RODS = {
    "wire, hinged": WIRE,
    "wire of 6.2 m, hinged": WIRE.replace(length=6.2),
    "wire, clamped": WIRE.replace(ends="clamped"),
    "tubing of 60 m, clamped": TUBING.replace(ends="clamped", damping_rate=0.5),
}
LOADS = (
    ("wire, hinged", (0.2, 0.25, 140.0), 7),
    ("wire, hinged", (0.6, 0.25, 124.0), 8),
    ("wire, hinged", (0.2, 0.3, 141.0), 7),
    ("wire, hinged", (0.3, 0.3, 133.0), 7),  # almost off the wall
    ("wire of 6.2 m, hinged", (0.2, 0.25, 143.0), 14),
    ("wire of 6.2 m, hinged", (0.5, 0.25, 142.0), 16),
    ("wire, clamped", (0.2, 0.25, 158.0), 7),
    ("wire, clamped", (0.2, 0.3, 192.0), 8),
    ("wire, clamped", (0.5, 0.25, 130.0), 7),
    ("tubing of 60 m, clamped", (0.2, 0.3, 26.3), 8),
    ("tubing of 60 m, clamped", (0.2, 0.3, 29.9), 9),
    ("tubing of 60 m, clamped", (0.5, 0.3, 24.2), 9),
)
"""Mean and amplitude in critical forces, frequency in rad/s, and the mode."""

ALMOST_LOST = 0.3  # of the weight: least contact force below which the motion is another one


def run() -> list[Row]:
    """Return angles, found and simulated."""
    return [row for case in LOADS for row in rows(*case)]


def rows(name: str, load: tuple[float, float, float], mode: int) -> Iterator[Row]:
    """Yield the angle found, how far it is from the simulated one, and the least contact force."""
    rod = RODS[name]
    mean, amplitude, frequency = load
    under = fr.AxialLoad(mean * rod.critical_force, amplitude * rod.critical_force, frequency)
    found = rod.steady_motion(with_waves(under, rod.damping_rate), mode)
    simulated = largest_simulated(rod, under, mode)
    what = f"{name}, {mean:g} + {amplitude:g} Fcr, {frequency:g} rad/s, mode {mode}"
    held = found.contact[0] / (rod.mass_per_length * rod.effective_gravity)
    most = 1.0 if rod.ends == "hinged" else 0.5
    yield Row(f"{what}: angle", found.amplitude, "rad")
    yield Row(f"{what}: simulated", simulated, "rad")
    yield Row(f"{what}: least contact force over the weight", held, "")
    off = 100.0 * abs(found.amplitude / simulated - 1.0)
    yield Row(f"{what}: apart by", off, "%", at_most=most if held > ALMOST_LOST else None)


def largest_simulated(rod: fr.Rod, under: fr.AxialLoad, mode: int) -> float:
    """Return the largest angle in rad of the simulated rod once it has settled, in its last twelve periods."""
    period = 2.0 * math.pi / under.frequency
    periods = round(16.0 / rod.damping_rate / period)
    kick = fr.Perturbation.modes({mode: rod.radial_clearance * 0.1 * under.frequency})
    run = fr.simulate(
        rod, under, duration=periods * period, frames=24 * periods + 1, perturbation=kick, segments=20 * mode
    )
    return float(run.largest_angle[-24 * 12 :].max())
