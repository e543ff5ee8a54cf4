"""A first verdict: one equation, one rod, one load."""

import floquetrod as fr

equation = fr.Mathieu(alpha=0.5, beta=-0.25)
print(fr.stability(equation))
print(fr.certify(equation))

rod = fr.Rod.nitinol()
for share in (0.05, 0.20, 0.34, 0.52, 0.63):
    load = fr.AxialLoad(mean=share * rod.critical_force, amplitude=0.2 * rod.critical_force, frequency=150.0)
    print(f"mean force {share:.2f} F_cr:", rod.stability(load))
