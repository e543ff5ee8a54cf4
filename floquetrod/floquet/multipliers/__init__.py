"""Multipliers of systems of equations: maps over a period, spectra with errors, verdicts, and names of resonances.

The methods for systems, `floquet/methods/system_*.py`, return eigenvalues with error discs: the numbers y = (mu +
1/mu - 2) / 4 of systems with pairs where they can, else the multipliers.  Only `classification` compares these with
the unit circle; `many_verdicts` applies its fast rules to batches and leaves undecided systems to
`floquetrod.stability`.  Methods share `spectra` (discs), `symplectic` (pairs, Krein signs), `half_period_maps` and
`whole_period_maps`, `independent_solutions` (one exponent of each), `precise_maps` and `precise_spectra` (many
digits), `verdicts_along_lines` (batches on a line), `resonance_names`.

*Marches.*  A linear equation is integrated over a period in nine ways; by the times measured, one for each kind of
number is not enough.  Balls have one, for equations and systems: `floquet/proof/system_flow.py`.  Many digits have two:
of one row 18 ms (`floquet/fixed_point.py`), as a system of one 66 ms (`precise_maps`).  Doubles have one for one row,
which also runs interpreted (`floquet/kernels/taylor.py`), one for systems (`floquet/kernels/system_maps*.py`) and one
for half a period of even systems (`floquet/kernels/system_even*.py`): 20,000 pairs of equations take 39 ms, over the
whole period 850.  Three serve other purposes: `floquet/kernels/phase_maps.py` carries one equation at many phases of
a second frequency side by side, `floquet/solve.py` computes a solution up to any time, and
`floquet/methods/leapfrog.py` is the published study's integrator.  Of pieces with constant
coefficients batches take exponentials: `floquet/kernels/constant_pieces.py` in closed form, `constant_matrices.py` by
series.
"""
