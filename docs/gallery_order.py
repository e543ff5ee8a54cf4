"""The order of the gallery: from a first verdict to what is built on it; scripts not named come last."""

from __future__ import annotations

from pathlib import Path

GALLERY = (
    "first_verdict",
    "chart",
    "frequency_choice",
    "my_rod",
    "thin_tongues",
    "friction",
    "simulation",
    "simulation_tubing",
    "simulation_stepped_load",
    "rod_backbone",
    "rod_not_straight",
    "helical_buckling",
    "vibration_and_drag",
    "well_bends",
    "tapered_string",
    "ensemble_phase_diagram",
    "ensemble_probability",
    "force_record",
    "real_inclined",
    "real_clamped",
    "real_lengths",
    "real_guidewire",
    "uncertainty",
    "systems_coupled",
    "systems_damping",
    "systems_noise",
    "parametric_amplifier",
    "systems_beam",
    "systems_blade",
    "systems_ground",
    "systems_trap",
    "systems_bands",
    "milling_lobes",
    "milling_variable_pitch",
    "orbit_van_der_pol",
    "orbit_duffing",
    "orbit_period_doubling",
)


class GalleryOrder:
    """What sphinx-gallery asks for: a key made for a folder, called with a file's name."""

    def __init__(self, folder: str) -> None:
        """Nothing depends on the folder."""

    def __call__(self, name: str) -> tuple[int, str]:
        """Return what to sort by."""
        stem = Path(name).stem
        return (GALLERY.index(stem) if stem in GALLERY else len(GALLERY), stem)
