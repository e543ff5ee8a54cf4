"""Formulas of docstrings set as mathematics on the pages of the reference; help() shows them as they are written."""

from __future__ import annotations

import re

import sphinx.application

FORMULAS = """
A'' + 2 c A' = (beta + alpha sin tau) A - gamma sign(A')
A'' + 2 c A' = (beta + alpha sin tau) A
A'' + 2 c A' = (beta + alpha sign(sin tau)) A
A'' + 2 c A' = (p(tau) + sum_k a_k cos(k w tau) + b_k sin(k w tau)) A
A'' + 2 c A' = (p(tau) + s xi) A
A'' + 2 c A' = (p(tau) + d.z) A
A'' + 2 c A' = p(tau) A + f(tau)
A'' + 2 c A' = p(tau) A
A'' + 2 c A' = p A + s eta
A'' + 2 c A' = p A + f
A'' = (beta + alpha sin tau) A
p(tau) = beta + alpha sin tau
p(tau) = beta + alpha sign(sin tau)
p(tau) = mean + sum_k cosines[k-1] cos(k W tau) + sines[k-1] sin(k W tau)
p = start + slope t + sum_k Re(z_k exp(i k W tau))
p = mean + sum_k Re(z_k exp(i k W tau))
W = 2 pi / period
w = 2 pi / period
2 pi / period
2 pi / w
-pi / period
pi / period
2 pi i / period
abs((beta + alpha sin tau) A) <= gamma
y'' + 2 k y' + (a - 2 q cos 2 z) y = 0
y'' + (a - 2 q cos 2 z) y = 0
2 q cos 2 z - a
x'' + 2 c x' + (delta + epsilon cos t) x = 0
x'' + (delta + epsilon cos t) x = 0
x'' + (-beta + alpha cos t) x = 0
(a, q) = (-4 beta, 2 alpha)
(alpha, beta) = (q / 2, -a / 4)
(delta, epsilon) = (-beta, alpha)
(alpha, beta) = (epsilon, -delta)
beta = -delta
alpha = q / 2
beta = -a / 4
c = k / 2
tau = 2 z + pi / 2
tau = t - pi / 2
tau = t - pi/2
sin tau = -cos t
beta + alpha
beta - alpha
-u'' + p u
A = exp(-c tau) u
p -> p + c^2
beta -> beta + c^2
d_k = D_k - a - q^2 / d_(k-1)
D_j - a >= 2 q
d_(k+1) = D_(k+1) - a - q^2 / d_k > 2 q - q = q
exp(i k W tau)
T >= delta = ((K + 1) W)^2 + mean - sum abs(z_k) > 0
N(H) = N(H_K - C T^-1 C*)
0 <= C T^-1 C* <= C C* / delta
N(H_K) <= N(H) <= N(H_K - C C* / delta)
cos(k tau / 2)
sin(k tau / 2)
det(even) det(odd) < 0 < det(1 + q) det(1 - q)
trace - 2 = 4 y1'(h) y2(h)
trace + 2 = 4 y1(h) y2'(h)
trace - 2 = 4 y1' y2
trace + 2 = 4 y1 y2'
r_1^2 = beta + alpha
r_2^2 = beta - alpha
C = cosh(h r)
S = sinh(h r) / r
h = pi / 2
alpha > abs(beta)
abs(A(end)) / A'(0)
abs(A) / kick
abs(a_m(q) - b_m(q))
exp(-2 c period)
exp(exponent t) p(t)
exp(-exponent t) x(t)
exp(exponent period)
x(t) = exp(exponent t) p(t)
A(tau) = exp(mu tau) P(tau)
y(t) = sum_k c_k exp((mu + i w_k) t)
exp(mu t)
exp(i nu z) P(z)
exp(i nu z)
exp(-4 pi c)
lambda_nu(q)
nu^2
M q'' + (C + G) q' + K(t) q + sum_j D_j(t) q(t - tau_j) = 0
M q'' + (C + G) q' + K(t) q + sum_i s_i G_i q xi_i = 0
M q'' + (C + G) q' + K(t) q = force(t, q, q', p)
M q'' + (C + G) q' + K(t) q = B eta(t)
M q'' + (C + G) q' + K(t) q = f(t)
M q'' + (C + G) q' + K(t) q = f
M q'' + (C + G) q' + K(t) q = 0
M q'' + C q' + K(t) q + (d.z) G q = 0
M q'' + C q' + K q = -depth H(t) (q(t) - q(t - tau))
tau = 2 pi / (teeth speed)
depth sum_j H_j(t) (q(t) - q(t - tau_j))
q'' + K(t) q = 0
K(t) = stiffness + sum_k cosines[k-1] cos k w t + sines[k-1] sin k w t
A(t) = mean + sum_k cosines[k-1] cos k w t + sines[k-1] sin k w t
start + slope (t - b) + sum_k cosines[k-1] cos k w t + sines[k-1] sin k w t
mean + sum_k Re(Z_k exp(i k w t))
f = mean + sum_k Re(harmonics[k-1] exp(i k W t))
x(t) = Re sum_k Z_k exp(i k w t)
x' = A(t) x + sum_j B_j(t) x(t - tau_j)
x' = A(t) x + (d.z) G x
x' = A(t) x + B eta
x' = A(t) x + f(t)
x' = A(t) x + f
x' = A(t) x
x' = f(t, x, p)
x = (u, u')
x = (u, p)
x = (q, q')
p = u' + G u / 2
q = L u
M^-1 = L L^T
u = exp(c t) q
q = exp(-c t) u
s = t - start
C = 2 c M
C + 2 rate M
A - rate I
u'' + (S + sum_k A_k cos k w s) u = 0
exp(i f period)
exp(-i e t) u(t)
2 w_i = k w
w_i + w_j = k w
w_i - w_j = k w
exp(s t) sum_k p_k exp(i k w t)
(mu + 1/mu - 2) / 4
y = (mu + 1/mu - 2) / 4
mu + 1/mu
B^T C
V^-1
S + S^-1
det(mu I - Phi(mu^-r))
x(t + T) = mu x(t)
x(t - r T) = mu^-r x(t)
-y'' + V(t) y = E y
y(t + T) = exp(i phase) y(t)
y'' = p y
M y'' + K y = 0
-M y'' + V y = E M y
1 / (pi T abs(dE / dphase))
p' = L(t) p
P = E[x x^T]
E[xi(t) xi(u)] = delta(t - u)
E[eta(t) eta(u)] = delta(t - u)
E[q q^T]
E[q^2]
sum_i s_i^2 G_i^2 / 2
G_i^2 = 0
G_i^-2
z' = F z + b xi
F = [[0, 1], [-w^2, -2 z w]]
x = exp(i w t) u(t)
x(t) = exp(i w t) u(t)
exp(i (w + 2 pi k / T) t)
exp(i (w + k W) t)
exp(i k w t)
exp(i w t)
exp(i w T)
1 / sqrt(2)
P' = A P + P A^T + B B^T
df_i / dx_j
D^2 = (c_i + c_j)^2
pi^2/3 - 1 = 2.29
A_s = pi (r_o^2 - r_i^2)
A_o = pi r_o^2
A_i = pi r_i^2
pi r_o^2
I = pi (r_o^4 - r_i^4) / 4
F_wall + p_i A_i - p_o A_o
g sin(inclination)
g cos(inclination)
m_t = rho A_s + rho_i A_i + C_a rho_o A_o
w_e = g (rho A_s + rho_i A_i - rho_o A_o)
w_e sin(inclination) / m_t
w_e sin(inclination) + F curvature
w_e sin(inclination)
w_e cos(inclination)
N = hypot(w_e sin(phi) + F kappa_n, F kappa_b)
N = hypot(w sin(phi) + F kappa_n, F kappa_b)
dF/ds = w cos(phi) - mu N
m R theta_tt + E I R theta_ssss + (F R theta_s)_s + N theta = 0
F^2 R / (4 E I)
R F^2 / (4 E I)
sqrt(w_e sin(inclination) / (R m_t))
F_cr = 2 sqrt(E I w_e sin(inclination) / R)
sqrt(E / rho)
sqrt(E rho)
G = E / (2 (1 + nu))
2 rho I l
k sqrt(d) (d + C v)
w = (7/6) (2 / l) sqrt(E / rho)
w^2 = (7/6)^2 (4/3) 16 E I / (m_t l^4)
2 / w
cos(omega L / c_0) = 0
sin(omega L / c_0) = 0
cos(omega L / (2 c_0)) = 0
omega L / (2 pi c_0)
omega L / c_0
1 / omega^2
q / (a - k^2 - q)
c^2
alpha_m = A (m^2 - h)
beta_m = B m^2 - C m^4 - D
tau = omega t
E I k_m^4 a_m
a_m sin(k_m s)
kappa_n = d phi / ds
kappa_b = sin(phi) d psi / ds
S + F^2 / S
F(t) = mean + amplitude sin(frequency t)
amplitude * sin(frequency * t)
sin(omega t)
u_tt + 2 c_a u_t = c_0^2 u_ss
kappa = sqrt(omega^2 - 2 i c_a omega) / c_0
cos kappa(L - s) / cos kappa L
sin kappa(L - s) / sin kappa L
cos kappa(s - L/2) / cos(kappa L/2)
Z = A sqrt(E rho)
(Z_2 - Z_1) / (Z_2 + Z_1)
theta = sum_m A_m sin(m pi s / L)
speed * sin(m pi s / L)
noise * sqrt(2/n)
beta = -a_m / 4
beta = -b_m / 4
ce(0) > 0
me_nu(0) > 0
"""
"""Formulas as docstrings write them, one a line."""

FRACTIONS = {
    "m_cr = [w_e sin(inclination) L^4 / (pi^4 R E I)]^(1/4)": (
        r"m_{cr} = \left[\frac{w_e L^4 \sin(\mathtt{inclination})}{\pi^4 R E I}\right]^{1/4}"
    ),
    "pi [E I R / (w_e sin(inclination))]^(1/4)": r"\pi \left[\frac{E I R}{w_e \sin(\mathtt{inclination})}\right]^{1/4}",
    "dF/dxi = mu w_across (1 + F^2 / F_p^2) - w_along": (
        r"\frac{dF}{d\xi} = \mu w_\mathrm{across} \left(1 + F^2 / F_p^2\right) - w_\mathrm{along}"
    ),
}
"""Formulas with large fractions, and in LaTeX."""

GREEK = re.compile("alpha|beta|gamma|delta|eta|theta|kappa|lambda|mu|nu|xi|pi|rho|tau|phi|psi|omega|Phi")
FUNCTIONS = {name: rf"\{name} " for name in ("sin", "cos", "cosh", "sinh", "det", "sum", "sqrt")}
FUNCTIONS |= {name: rf"\operatorname{{{name}}}" for name in ("sign", "hypot", "Re")}
FUNCTIONS |= {name: rf"\mathrm{{{name}}}" for name in ("ce", "me", "se", "even", "odd", "trace", "wall", "end")}
SIGNS = {
    "<=": r"\le ",
    ">=": r"\ge ",
    "->": r"\to ",
    " * ": r"\,",
    "*": "^*",
    "[k-1]": "_{k-1}",
    "epsilon": r"\varepsilon ",
}
WRAPPED = {"abs": "|{}|", "sqrt": r"\sqrt{{{}}}", "exp": "e^{{{}}}", "^": "^{{{}}}", "_": "_{{{}}}"}
"""What is put about the argument of a function, an exponent or an index in parentheses."""

TOKEN = re.compile(r"(abs|sqrt|exp|\^|_)\(|\^(-?\w+)|_(\w+)|\[k-1\]|[A-Za-z]\d|(?<=\w)\*| \* |[A-Za-z]+|<=|>=|->|.")


def latex(plain: str) -> str:
    """Return a formula of a docstring in LaTeX."""
    if plain in FRACTIONS:
        return FRACTIONS[plain]
    found, place = [], 0
    while token := TOKEN.match(plain, place):
        wrapped, power, index = token.groups()
        place = token.end()
        if wrapped:
            end = closing(plain, place)
            found.append(WRAPPED[wrapped].format(latex(plain[place:end])))
            place = end + 1
        elif power or index:
            found.append(f"{token[0][0]}{{{word(power or index)}}}")
        else:
            found.append(SIGNS.get(token[0]) or word(token[0]))
    return re.sub(r"(?<=[\w}]) (?=\\mathtt)|(?<=[\w]}) (?=[\w\\(])", r"\\,", "".join(found)).strip()


def closing(text: str, place: int) -> int:
    """Return where the parenthesis closes that was opened before a place."""
    depth = 1
    while depth:
        depth += {"(": 1, ")": -1}.get(text[place], 0)
        place += 1
    return place - 1


def word(name: str) -> str:
    """Return a name or a sign of a formula in LaTeX; names of arguments look as in code."""
    if GREEK.fullmatch(name):
        return rf"\{name} "
    if name in FUNCTIONS:
        return FUNCTIONS[name]
    if re.fullmatch(r"dphase|dxi", name):
        return f"d{word(name[1:])}"
    if re.fullmatch(r"[A-Za-z]\d", name):
        return f"{name[0]}_{name[1]}"
    return name if len(name) < 4 or set(name) <= {"s", "t"} else rf"\mathtt{{{name}}}"


PLAIN = {*FORMULAS.strip().splitlines(), *FRACTIONS}
_EITHER = "|".join(map(re.escape, sorted(PLAIN, key=len, reverse=True)))
# Between what Sphinx lets a role stand: not before "(", say, where the formula goes on.
_ANY = re.compile(rf"(?<![^\s\"(\[{{<\-/:])(?:{_EITHER})(?![^\s\")\]}}>\-/:.,;!?])")


def typeset(text: str) -> str:
    """Return a line of a docstring with its formulas as mathematics; examples and rows of tables are left alone."""
    if ">>>" in text or "   " in text.strip():
        return text
    return _ANY.sub(lambda found: f":math:`{latex(found[0])}`", text)


def _typeset(app: object, what: str, name: str, thing: object, options: object, lines: list[str]) -> None:
    lines[:] = map(typeset, lines)


def setup(app: sphinx.application.Sphinx) -> dict[str, bool]:
    """Typeset docstrings after napoleon has read them: it takes what precedes a colon for a type."""
    app.connect("autodoc-process-docstring", _typeset, priority=900)
    return {"parallel_read_safe": True}
