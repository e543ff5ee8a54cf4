"""
Ground resonance with one damper out
====================================

A helicopter on the ground: four blades that swing in the plane of the rotor, on a hub that can move.  The mass matrix
turns with the rotor, so the system is given as a function.  With one of the four lag dampers out it is unstable in a
range of rotor speeds.
"""

import matplotlib.pyplot as plt
import numpy as np

import floquetrod as fr
from floquetrod.plotting import palette

mass, moment, inertia, hinge = 94.9, 289.1, 1084.7, 0.3048  # of a blade: kg, kg m, kg m^2, m
hub, stiffness, friction = 8026.6, 1240481.8, 51078.7  # kg, N/m, N s/m, the same in both directions
lag = 4067.5  # N m s, of one lag damper


def rotor(speed: float, dampers: np.ndarray) -> fr.PeriodicSystem:
    """Return the system of four lag angles and two displacements of the hub; its time is the azimuth, in radians."""
    weights = np.diag(np.r_[np.full(4, inertia), np.full(2, hub + 4.0 * mass)])
    losses = np.diag(np.r_[dampers, np.full(2, friction)]) / speed
    springs = np.diag(np.r_[np.full(4, hinge * moment), np.full(2, stiffness / speed**2)])

    def coefficient(azimuth: float) -> np.ndarray:
        sine, cosine = (moment * wave(azimuth + 0.5 * np.pi * np.arange(4)) for wave in (np.sin, np.cos))
        M, C, K = weights.copy(), losses.copy(), springs.copy()
        M[:4, 4], M[:4, 5] = -sine, cosine
        M[4, :4], M[5, :4] = -sine, cosine
        C[4, :4], C[5, :4] = -2.0 * cosine, -2.0 * sine
        K[4, :4], K[5, :4] = sine, -cosine
        return np.block([[np.zeros((6, 6)), np.eye(6)], [-np.linalg.solve(M, K), -np.linalg.solve(M, C)]])

    return fr.PeriodicSystem.from_function(coefficient, period=2.0 * np.pi)


all_work, one_out = np.full(4, lag), np.array([0.0, lag, lag, lag])
verdict = fr.stability(rotor(18.0, one_out))
print(verdict)
print(f"at 18 rad/s motion grows by {18.0 * verdict.growth_rate:.6f} per second")

# %%
# The exponent with the largest real part over the rotor speed.
speeds = np.linspace(10.0, 26.0, 65)
figure, axes = plt.subplots(figsize=(8.0, 4.2), layout="constrained")
for dampers, line, label in ((one_out, "-", "one damper out"), (all_work, "--", "all dampers work")):
    largest = np.array([speed * fr.stability(rotor(speed, dampers)).exponents[0].real for speed in speeds])
    axes.fill_between(speeds, 0.0, largest, where=largest > 0.0, color=palette.UNSTABLE, interpolate=True)
    axes.plot(speeds, largest, color="black", linestyle=line, label=label)
    unstable = speeds[largest > 0.0]
    print(f"{label}:", f"unstable from {unstable[0]:.2f} to {unstable[-1]:.2f} rad/s" if unstable.size else "stable")
axes.axhline(0.0, color="black", linewidth=0.5)
axes.set(xlabel="rotor speed / (rad/s)", ylabel="largest real part / (1/s)", xlim=(speeds[0], speeds[-1]))
axes.set_title("exponents of ground resonance; orange: unstable", fontsize="small")
axes.legend(fontsize="small")
plt.show()
