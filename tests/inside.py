"""What several test files take from deep inside the package, named once: where it moves, this table changes alone.

A test asks the public face first.  What stands here has no public question, or is itself what the tests are about.
"""

from __future__ import annotations

from floquetrod._util.lazy import names_of

__getattr__, __dir__ = names_of(
    __name__,
    {
        "floquet.kernels.leapfrog_map": ("leapfrog_map_fill",),
        "floquet.kernels.system_even": ("half_period_map", "pair_numbers"),
        "floquet.kernels.taylor": ("advance", "mathieu_map_fill"),
        "floquet.mathieu_chains.mathieu_counts": ("count_below",),
        "floquet.methods.system_half_period": ("half_period", "solved_pairs"),
        "floquet.methods.system_monodromy": ("solved_many",),
        "floquet.multipliers.resonance_names": ("Resonance",),
        "floquet.proof.balls": ("Doubles",),
        "floquet.proof.integers": ("Integers",),
        "floquet.proof.many_digits": ("TooMuchWork", "Unresolved", "arithmetic", "cosh_sinhc", "pi"),
        "floquet.proof.system_counts": ("Counts", "angles_between", "count"),
        "floquet.proof.system_flow": ("monodromy",),
        "floquet.proof.system_numbers": ("system_problem",),
        "rod.answers.mean_force": ("drag_of", "friction_along"),
        "rod.answers.rod_box": ("RodBox",),
        "rod.answers.sliding": ("damping_across", "least_speed"),
        "rod.answers.stress_along": ("stress_along", "stress_of"),
        "rod.friction.mode_friction": ("mode_friction",),
        "rod.loads.axial": ("wave_ratio",),
        "rod.loads.load": (
            "AnyLoad",
            "FAR_ENDS",
            "LOAD",
            "Load",
            "Loads",
            "QUANTITIES",
            "Quantity",
            "kind",
            "load_from_dict",
            "scaled_noise",
            "with_waves",
        ),
        "rod.mode_equations.coupled_matrices": ("CoupledModes", "modes_needed", "up_to_resonance"),
        "rod.mode_equations.coupled_systems": ("CoupledEquations",),
        "rod.mode_equations.large_motion": ("LargeMotion", "Shapes"),
        "rod.mode_equations.one_mode": ("OneMode", "Orbit"),
        "rod.model.catalogue": ("CataloguePipe", "pipe", "pipes", "weight_in_air"),
        "rod.model.constants": ("ModeConstants", "SLOW_GROWTH", "mode_constants"),
        "rod.model.data": ("wavenumber",),
        "rod.model.parameters": ("GIVEN", "INSTEAD", "NUMBERS", "ON_A_FLOOR", "ROD"),
        "rod.model.plausibility": ("may_be_hertz", "suspicions_of_load", "suspicions_of_record", "suspicions_of_rod"),
        "rod.model.rod_file": ("SURVEY_KEYS", "read_rod"),
        "rod.modes.coupled": ("CoupledModel",),
        "rod.modes.mode_model": ("Answers", "ModeModel"),
        "simulation.kernels.well_anchors": ("beside",),
    },
)
