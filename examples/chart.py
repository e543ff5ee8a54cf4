"""
The stability chart
===================

The Ince-Strutt chart of Mathieu's equation with its exact boundaries, each labelled with its name.
"""

import matplotlib.pyplot as plt
import numpy as np

import floquetrod as fr

chart = fr.mathieu.chart((0.0, 3.0, 400), (-4.5, 1.0, 400))
print(chart)

axes = chart.plot()
fr.mathieu.transition_curves(np.linspace(0.0, 3.0, 200), 4).plot(axes)
axes.set_ylim(-4.5, 1.0)
axes.set_title("Mathieu's equation, solutions of period $4\\pi$ solid, $2\\pi$ dashed", fontsize="medium")
plt.show()
