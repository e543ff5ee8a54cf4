"""The Ince-Strutt chart with its exact boundaries, written to chart.png."""

import numpy as np

import floquetrod as fr
from floquetrod.plotting.charts import save_figure

chart = fr.mathieu.chart((0.0, 3.0, 400), (-4.5, 1.0, 400))
axes = chart.plot()
fr.mathieu.transition_curves(np.linspace(0.0, 3.0, 200), 4).plot(axes)
axes.set_ylim(-4.5, 1.0)
axes.set_title(
    "Mathieu's equation: unstable where grey; curves solid: period $4\\pi$, dashed: $2\\pi$", fontsize="small"
)
print(chart)
print("written:", save_figure(axes, "chart.png"))
