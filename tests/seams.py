"""Constants of the package that tests change, so that limits of hours or gigabytes are reached in milliseconds.

`tuned(seconds_between_checkpoints=0.0)`, a fixture of `conftest.py`, sets one for a test, wherever modules name it.
The functions whose answers depend on the machine stand with them.  What moves or is renamed changes here alone.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

Tuned = Callable[..., None]
"""The fixture `tuned`."""

Forbidden = Callable[[Any, str], None]
"""The fixture `forbidden`."""

Heard = Callable[[Any, str], list[tuple[Any, ...]]]
"""The fixture `heard`."""

CONSTANTS = {
    # what is printed
    "rows_of_a_printed_table": ("cli.ensemble._ROWS",),
    "can_redraw_a_line": ("_util.waiting.can_redraw",),
    "seconds_between_plain_lines": ("_util.waiting.PLAIN",),
    # compiling
    "seconds_for_another_to_compile": ("_util.kernel_cache._LONGEST",),
    "seconds_worth_a_thread": ("_util.compilation._WORTH_A_THREAD",),
    "interpreted_work": ("_util.compilation._INTERPRETED",),
    "often_asked_kernels": ("floquet.kernels.system_series.OFTEN_ASKED",),
    "is_series_kernel_on_disk": ("floquet.kernels.system_series.is_at_hand",),
    "is_modes_kernel_on_disk": ("rod.mode_equations.modal_systems.is_at_hand",),
    "milliseconds_to_load_numba": ("rod.mode_equations.modal_systems._LOADING",),
    "maps_compiled_after": ("floquet.kernels.system_even._COMPILE_AFTER", "floquet.kernels.system_maps._COMPILE_AFTER"),
    "functions_compiled_after": ("mathieu.array_functions._COMPILE_AFTER",),
    "leapfrog_compiled_after": ("floquet.methods.leapfrog._COMPILE_AFTER",),
    # files
    "bytes_of_a_sealed_file": ("_util.sealed_files._LARGEST",),
    "bytes_of_a_system_file": ("equations.system_files._LARGEST",),
    "seconds_between_checkpoints": ("simulation.checkpoints._SECONDS_BETWEEN",),
    "seconds_between_saves_of_stores": ("ensembles.stores._SECONDS_BETWEEN",),
    "durations_between_saves_of_stores": ("ensembles.stores._LONGER",),
    "bytes_of_frames_in_memory": ("ensembles.stores.MOST_MEMORY",),
    "arithmetic_of_stores": ("ensembles.stores.arithmetic",),
    "arithmetic_of_checkpoints": ("simulation.checkpoints.arithmetic",),
    "deaths_of_workers_in_a_run": ("ensembles.workers._DEATHS",),
    # orbits
    "orbit_kernels": ("orbits.collocation.machine_code",),
    "equations_of_orbit_kernels": ("orbits.kernels.MOST_EQUATIONS",),
    # equations and systems
    "steps_of_a_solution": ("floquet.solve._MOST_STEPS",),
    "equations_of_an_explicit_map": ("floquet.kernels.system_even._EXPLICIT_UP_TO",),
    "segments_worth_stopping": ("floquet.kernels.system_large._WORTH_STOPPING",),
    "equations_of_both_ends_at_once": ("floquet.kernels.system_even_large._TOGETHER",),
    "relative_error_that_is_settled": ("floquet.methods.system_reference._SETTLED",),
    "equations_of_many": ("floquet.methods.system_monodromy._MANY",),
    "columns_drawn_at_random": ("floquet.multipliers.fastest_solutions._COLUMNS",),
    "chance_of_a_short_projection": ("floquet.multipliers.fastest_solutions._CHANCE",),
    "modes_whose_resonances_are_named": ("floquet.multipliers.resonance_names._MOST_MODES",),
    "seconds_of_a_damping_search": ("floquet.multipliers.stabilising_damping._MOST_SECONDS",),
    "unit_of_rounding": ("floquet.proof.kernels.double_intervals.ULP",),
    "smallest_step_outwards": ("floquet.proof.kernels.double_intervals.TINY",),
    "pending_modes_listed": ("floquet.proof.kernels.regions._LISTED",),
    # rods
    "modes_of_a_long_rod": ("rod.modes.coupled_verdict._LONG",),
    "modes_judged_together": ("rod.modes.coupled_verdict.SEVERAL",),
    "modes_worth_following": ("rod.modes.fewer_modes._WORTH",),
    "most_coupled_modes": ("rod.mode_equations.coupled_matrices.MOST_COUPLED",),
    "modes_told_as_few": ("rod.answers.rod_stability.FEW_MODES",),
    "samples_of_ranges": ("rod.modes.sampled_ranges.SAMPLES",),
    "least_samples_of_a_group": ("rod.modes.sampled_ranges._LEAST_SAMPLES",),
    "groups_of_frequencies": ("rod.modes.sampled_ranges._GROUPS",),
    "largest_angle": (
        "rod.kicked_motion.LIMIT",
        "rod.large_orbits.LIMIT",
        "rod.mode_equations.many_orbits.LIMIT",
        "rod.motion.LIMIT",
    ),
    "rounds_of_a_shaken_string": ("wells.strings._TURNS",),
    # the explorer
    "points_of_a_chart": ("explorer.maps._POINTS",),
    "cells_of_a_growing_map": ("explorer.maps._MAP",),
    "coarsenings_of_a_growing_map": ("explorer.maps._COARSENINGS",),
    "frequencies_of_a_line": ("explorer.mode_panels._LINE",),
    # simulation
    "share_of_the_critical_step": ("simulation.step_size.SAFETY",),
    "element_steps_of_a_call": ("simulation.integration._ELEMENT_STEPS",),
    "least_steps_of_a_call": ("simulation.integration._LEAST_STEPS",),
    "swings_that_are_growth": ("simulation.outcome._GROWN",),
}
"""The modules and names of each constant."""
