"""Kernel for the leapfrog scheme: kick, drift, kick, with damping split symmetrically about them."""

from __future__ import annotations

import math
from typing import Any

from floquetrod._util.compilation import kernel


@kernel
def leapfrog_map_fill(alpha: Any, beta: Any, damping: Any, out: Any, wave: Any, period: float) -> None:
    """Fill ``out`` (n, 5) with the scheme's map over a period: (A, A') from (1, 0), from (0, 1), and a logarithm.

    The map is the first four numbers times the exponential of the fifth.  A'' = (beta + alpha wave) A - 2 damping A',
    ``wave`` at equal steps over the period.
    """
    # The leapfrog or Stoermer-Verlet scheme of order 2 (E. Hairer, C. Lubich and G. Wanner, Acta Numerica 12 (2003)
    # 399, doi:10.1017/S0962492902000144), h = period / count, p_i = beta + alpha wave[i], damping e^-ch on either side:
    #     v <- e^-ch v + (h / 2) p_i a,    a <- a + h v,    v <- e^-ch (v + (h / 2) p_(i+1) a).
    # Two motions (a1, v1), (a2, v2) are carried at once: the columns of the map, whose determinant e^(-2 c period) is
    # exact.  The end of a step shares p with the beginning of the next.  Powers are taken out by logarithms before
    # doubles end.
    count = len(wave)
    h = period / count
    for point in range(len(alpha)):
        decay = math.exp(-damping[point] * h)
        a1, v1, a2, v2 = 1.0, 0.0, 0.0, 1.0
        taken = 0.0
        kick = 0.5 * h * (beta[point] + alpha[point] * wave[0])
        for i in range(count):
            v1 = v1 * decay + kick * a1
            v2 = v2 * decay + kick * a2
            a1 += h * v1
            a2 += h * v2
            kick = 0.5 * h * (beta[point] + alpha[point] * wave[(i + 1) % count])
            v1 = (v1 + kick * a1) * decay
            v2 = (v2 + kick * a2) * decay
            size = max(abs(a1), abs(v1), abs(a2), abs(v2))
            if size > 1e100:
                a1, v1, a2, v2 = a1 / size, v1 / size, a2 / size, v2 / size
                taken += math.log(size)
        out[point, 0] = a1
        out[point, 1] = v1
        out[point, 2] = a2
        out[point, 3] = v2
        out[point, 4] = taken
