"""Formulas of docstrings set as mathematics on the pages of the reference; help() shows them as they are written."""

from __future__ import annotations

import re

import sphinx.application

FORMULAS = {
    # equations
    "A'' + 2 c A' = (beta + alpha sin tau) A - gamma sign(A')": (
        r"A'' + 2 c A' = (\beta + \alpha \sin\tau) A - \gamma\,\mathrm{sign}(A')"
    ),
    "A'' + 2 c A' = (beta + alpha sin tau) A": r"A'' + 2 c A' = (\beta + \alpha \sin\tau) A",
    "A'' + 2 c A' = (beta + alpha sign(sin tau)) A": (r"A'' + 2 c A' = (\beta + \alpha\,\mathrm{sign}(\sin\tau)) A"),
    "A'' + 2 c A' = p(tau) A": r"A'' + 2 c A' = p(\tau) A",
    "A'' = (beta + alpha sin tau) A": r"A'' = (\beta + \alpha \sin\tau) A",
    "p(tau) = beta + alpha sin tau": r"p(\tau) = \beta + \alpha \sin\tau",
    "p(tau) = beta + alpha sign(sin tau)": r"p(\tau) = \beta + \alpha\,\mathrm{sign}(\sin\tau)",
    "p(tau) = mean + sum_k cosines[k-1] cos(k W tau) + sines[k-1] sin(k W tau)": (
        r"p(\tau) = \mathtt{mean} + \sum_k \mathtt{cosines}_{k-1} \cos k W \tau + \mathtt{sines}_{k-1} \sin k W \tau"
    ),
    "p = start + slope t + sum_k Re(z_k exp(i k W tau))": (
        r"p = \mathtt{start} + \mathtt{slope}\,t + \sum_k \mathrm{Re}\,(z_k e^{i k W \tau})"
    ),
    "p = mean + sum_k Re(z_k exp(i k W tau))": r"p = \mathtt{mean} + \sum_k \mathrm{Re}\,(z_k e^{i k W \tau})",
    "abs((beta + alpha sin tau) A) <= gamma": r"|(\beta + \alpha \sin\tau) A| \le \gamma",
    "y'' + 2 k y' + (a - 2 q cos 2 z) y = 0": r"y'' + 2 k y' + (a - 2 q \cos 2 z) y = 0",
    "y'' + (a - 2 q cos 2 z) y = 0": r"y'' + (a - 2 q \cos 2 z) y = 0",
    "x'' + (delta + epsilon cos t) x = 0": r"x'' + (\delta + \varepsilon \cos t) x = 0",
    "(a, q) = (-4 beta, 2 alpha)": r"(a, q) = (-4\beta, 2\alpha)",
    "(alpha, beta) = (q / 2, -a / 4)": r"(\alpha, \beta) = (q/2, -a/4)",
    "(delta, epsilon) = (-beta, alpha)": r"(\delta, \varepsilon) = (-\beta, \alpha)",
    "(alpha, beta) = (epsilon, -delta)": r"(\alpha, \beta) = (\varepsilon, -\delta)",
    "tau = 2 z + pi / 2": r"\tau = 2 z + \pi/2",
    # systems
    "M q'' + (C + G) q' + K(t) q = 0": r"M q'' + (C + G) q' + K(t) q = 0",
    "K(t) = stiffness + sum_k cosines[k-1] cos k w t + sines[k-1] sin k w t": (
        r"K(t) = \mathtt{stiffness} + \sum_k \mathtt{cosines}_{k-1} \cos k w t + \mathtt{sines}_{k-1} \sin k w t"
    ),
    "A(t) = mean + sum_k cosines[k-1] cos k w t + sines[k-1] sin k w t": (
        r"A(t) = \mathtt{mean} + \sum_k \mathtt{cosines}_{k-1} \cos k w t + \mathtt{sines}_{k-1} \sin k w t"
    ),
    "x' = A(t) x": r"x' = A(t) x",
    "u'' + (S + sum_k A_k cos k w s) u = 0": r"u'' + \left(S + \sum_k A_k \cos k w s\right) u = 0",
    # the rod and its loads
    "pi^2/3 - 1 = 2.29": r"\pi^2/3 - 1 = 2.29",
    "A_s = pi (r_o^2 - r_i^2)": r"A_s = \pi (r_o^2 - r_i^2)",
    "A_o = pi r_o^2": r"A_o = \pi r_o^2",
    "A_i = pi r_i^2": r"A_i = \pi r_i^2",
    "I = pi (r_o^4 - r_i^4) / 4": r"I = \pi (r_o^4 - r_i^4) / 4",
    "g sin(inclination)": r"g \sin(\text{inclination})",
    "g cos(inclination)": r"g \cos(\text{inclination})",
    "m_t = rho A_s + rho_i A_i + C_a rho_o A_o": r"m_t = \rho A_s + \rho_i A_i + C_a \rho_o A_o",
    "w_e = g (rho A_s + rho_i A_i - rho_o A_o)": r"w_e = g (\rho A_s + \rho_i A_i - \rho_o A_o)",
    "w_e sin(inclination) / m_t": r"w_e \sin(\text{inclination}) / m_t",
    "sqrt(w_e sin(inclination) / (R m_t))": r"\sqrt{w_e \sin(\text{inclination}) / (R m_t)}",
    "F_cr = 2 sqrt(E I w_e sin(inclination) / R)": r"F_{cr} = 2 \sqrt{E I w_e \sin(\text{inclination}) / R}",
    "m_cr = [w_e sin(inclination) L^4 / (pi^4 R E I)]^(1/4)": (
        r"m_{cr} = \left[\frac{w_e L^4 \sin(\text{inclination})}{\pi^4 R E I}\right]^{1/4}"
    ),
    "pi [E I R / (w_e sin(inclination))]^(1/4)": (r"\pi \left[\frac{E I R}{w_e \sin(\text{inclination})}\right]^{1/4}"),
    "sqrt(E / rho)": r"\sqrt{E / \rho}",
    "omega L / (2 pi c_0)": r"\omega L / (2 \pi c_0)",
    "F(t) = mean + amplitude sin(frequency t)": (
        r"F(t) = \mathtt{mean} + \mathtt{amplitude} \cdot \sin(\mathtt{frequency} \cdot t)"
    ),
    "u_tt + 2 c_a u_t = c_0^2 u_ss": r"u_{tt} + 2 c_a u_t = c_0^2 u_{ss}",
    "kappa = sqrt(omega^2 - 2 i c_a omega) / c_0": r"\kappa = \sqrt{\omega^2 - 2 i c_a \omega} / c_0",
    "dF/dxi = mu w_across (1 + F^2 / F_p^2) - w_along": (
        r"\frac{dF}{d\xi} = \mu w_\mathrm{across} \left(1 + F^2 / F_p^2\right) - w_\mathrm{along}"
    ),
    # solutions
    "y(t) = sum_k c_k exp((mu + i w_k) t)": r"y(t) = \sum_k c_k e^{(\mu + i w_k) t}",
}
"""Formulas as docstrings write them, and in LaTeX."""

_ANY = re.compile("|".join(re.escape(plain) for plain in sorted(FORMULAS, key=len, reverse=True)))


def typeset(text: str) -> str:
    """Return a line of a docstring with its formulas as mathematics; examples and rows of tables are left alone."""
    if ">>>" in text or "   " in text.strip():
        return text
    return _ANY.sub(lambda found: f":math:`{FORMULAS[found[0]]}`", text)


def _typeset(app: object, what: str, name: str, thing: object, options: object, lines: list[str]) -> None:
    lines[:] = map(typeset, lines)


def setup(app: sphinx.application.Sphinx) -> dict[str, bool]:
    """Typeset docstrings after napoleon has read them: it takes what precedes a colon for a type."""
    app.connect("autodoc-process-docstring", _typeset, priority=900)
    return {"parallel_read_safe": True}
