"""Methods, one to a file: from an equation to a verdict, in files ``system_`` from a system; none calls another.

`floquetrod.compare` shows whether the methods agree, which is evidence only while they compute in different
ways.  The methods for equations share neither algorithm nor code above `floquetrod.floquet.verdict`.  The methods for
systems share the classification and the linear algebra in `floquetrod.floquet.multipliers`; maps by Taylor series
(`half_period`, `monodromy`, `segmented`, with kernels in common), Hill's matrix (`spectral`) and series in integers,
with bounds (`reference`), are three different computations.
"""
