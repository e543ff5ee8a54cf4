"""The modes of a rod under a kind of load: independent or coupled, behind one interface.

A `ModeModel` describes the modes under a kind of load: their equations, verdicts, status and growth over arrays of
loads, ranges, bands, proofs and samples.  `Rod._modes_under` chooses it, and no other code asks which one it is; for a
task that a model cannot do it raises an error that names the remedy.

Where the ends are hinged and the force is a sine, uniform along the rod, each mode is Mathieu's equation
(`independent`), and ranges are found by counting.  Otherwise (`coupled`) the modes are a `HillSystem` in seconds: beam
functions for the rod's ends and a few others, the mean force in its stiffness, the vibration in its cosine and sine
matrices.  `coupled_verdict` calls `floquetrod.stability` with two or three numbers of modes, and with more while the
verdicts differ; the difference enters the error.  Of many modes `floquet/multipliers/resonating_modes.py` leaves the
ones that may resonate.  Searches of coupled modes sample, and state their resolution.

Every verdict is a `RodStability`: the model of the modes, one record of evidence for each kind of modes
(`rod/answers/evidence.py`), and the words, tables and numbers for all of them (`rod/answers/rod_stability.py`).
"""
