"""Kernels for the anchors of a rod simulated in a well: points of its axis that follow the nodes.

Each node has an anchor on the axis: a point c, the tangent t and the vector of curvature k there.  With o = r - c the
point of the axis nearest to the node is, to the third order of its distance xi from the anchor,

    c + xi t + xi^2 k / 2,    xi = t.o / (1 - k.o),    tangent  t + xi k,    offset  q = o - xi t - xi^2 k / 2 .

Anchors follow the nodes along the exact arcs every few steps, in which a node moves by some micrometres.  That the loop
over the nodes reads anchors and not the arcs is what lets compilers vectorise it.
"""

from __future__ import annotations

import math
from typing import Any

from floquetrod._util.compilation import kernel
from floquetrod.simulation.rod_record import FIRST


@kernel
def _follow(rod: Any, first: int, last: int, p: Any) -> None:
    """Move the anchors of nodes to the points of the axis nearest to them."""
    # A row of arcs: 0 begins at s, 1-3 point, 4-6 tangent t, 7-9 normal n there, 10 curvature b.  On an arc, at
    # ``below`` = d,
    #     c = p + (sin bd / b) t + ((1 - cos bd) / b) n,   t' = cos bd t + sin bd n,   k' = b (cos bd n - sin bd t),
    # c, t' and k' the point, the tangent and the curvature; 1 - cos bd is 2 sin^2(bd / 2), which does not cancel; a
    # straight piece has b = 0.  One step of Newton's method from the last anchor (head of the file) gives s; the arc
    # that holds it is next to the last one.
    arcs = p.well.arcs
    x, y, z, c1, c2, c3 = rod["x"], rod["y"], rod["z"], rod["c1"], rod["c2"], rod["c3"]
    t1, t2, t3, k1, k2, k3 = rod["t1"], rod["t2"], rod["t3"], rod["k1"], rod["k2"], rod["k3"]
    place, arc = rod["place"], rod["arc"]
    for i in range(first, last):
        o1, o2, o3 = x[i] - c1[i], y[i] - c2[i], z[i] - c3[i]
        room = 1.0 - (k1[i] * o1 + k2[i] * o2 + k3[i] * o3)
        s = place[i] + (t1[i] * o1 + t2[i] * o2 + t3[i] * o3) / room
        j = int(arc[i])
        while j + 1 < len(arcs) and s >= arcs[j + 1, 0]:
            j += 1
        while j > 0 and s < arcs[j, 0]:
            j -= 1
        below, bend = s - arcs[j, 0], arcs[j, 10]
        sine, cosine = math.sin(bend * below), math.cos(bend * below)
        half = math.sin(0.5 * bend * below)
        run, off = (sine / bend, 2.0 * half * half / bend) if bend > 0.0 else (below, 0.0)
        c1[i] = arcs[j, 1] + run * arcs[j, 4] + off * arcs[j, 7]
        c2[i] = arcs[j, 2] + run * arcs[j, 5] + off * arcs[j, 8]
        c3[i] = arcs[j, 3] + run * arcs[j, 6] + off * arcs[j, 9]
        t1[i] = cosine * arcs[j, 4] + sine * arcs[j, 7]
        t2[i] = cosine * arcs[j, 5] + sine * arcs[j, 8]
        t3[i] = cosine * arcs[j, 6] + sine * arcs[j, 9]
        k1[i] = bend * (cosine * arcs[j, 7] - sine * arcs[j, 4])
        k2[i] = bend * (cosine * arcs[j, 8] - sine * arcs[j, 5])
        k3[i] = bend * (cosine * arcs[j, 9] - sine * arcs[j, 6])
        place[i], arc[i] = s, j


@kernel
def _follow_end(rod: Any, i: int, place: int, p: Any) -> None:
    """Move the anchor of an end, and turn with its tangent where the end is held across."""
    # The vector h from the axis to the held end, at right angles to the old tangent o, goes with the smallest rotation
    # that takes o to the new tangent n: h - (h.n) / (1 + o.n) (o + n).  So it does not wind about the axis.
    hold = rod["anchor"]
    o1, o2, o3 = rod["t1"][i], rod["t2"][i], rod["t3"][i]
    _follow(rod, i, i + 1, p)
    n1, n2, n3 = rod["t1"][i], rod["t2"][i], rod["t3"][i]
    a, b, c = 3 * place, 3 * place + 1, 3 * place + 2
    part = (hold[a] * n1 + hold[b] * n2 + hold[c] * n3) / (1.0 + o1 * n1 + o2 * n2 + o3 * n3)
    hold[a] -= part * (o1 + n1)
    hold[b] -= part * (o2 + n2)
    hold[c] -= part * (o3 + n3)


@kernel
def follow(rod: Any, p: Any) -> None:
    """Move every anchor to the point of the axis nearest to its node."""
    a, b = FIRST, FIRST + p.segments
    _follow_end(rod, a, 0, p)
    _follow_end(rod, b, 1, p)
    _follow(rod, a + 1, b, p)


@kernel
def dot(a: Any, b: Any) -> float:
    """Return the scalar product of two vectors."""
    product: float = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    return product


@kernel
def cross(a: Any, b: Any, scale: float) -> Any:
    """Return the vector product of two vectors times ``scale``."""
    return (
        scale * (a[1] * b[2] - a[2] * b[1]),
        scale * (a[2] * b[0] - a[0] * b[2]),
        scale * (a[0] * b[1] - a[1] * b[0]),
    )


@kernel
def from_axis(o: Any, t: Any, k: Any, inverse: float) -> Any:
    """Return the place beyond the anchor, and the tangent there, of the point of the axis nearest to a node.

    With them the offset of the node from there, in units of 1 / ``inverse``; the node is at ``o`` from its anchor,
    where the axis has the tangent ``t`` and the curvature ``k``.
    """
    along = dot(t, o) / (1.0 - dot(k, o))
    half = 0.5 * along
    offset = (
        inverse * (o[0] - along * (t[0] + half * k[0])),
        inverse * (o[1] - along * (t[1] + half * k[1])),
        inverse * (o[2] - along * (t[2] + half * k[2])),
    )
    return along, (t[0] + along * k[0], t[1] + along * k[1], t[2] + along * k[2]), offset


@kernel
def beside(rod: Any, i: int) -> Any:
    """Return the place of a node along the axis, the tangent there, and the offset of the node from there."""
    o = rod["x"][i] - rod["c1"][i], rod["y"][i] - rod["c2"][i], rod["z"][i] - rod["c3"][i]
    t, k = (rod["t1"][i], rod["t2"][i], rod["t3"][i]), (rod["k1"][i], rod["k2"][i], rod["k3"][i])
    along, tangent, offset = from_axis(o, t, k, 1.0)
    return rod["place"][i] + along, tangent, offset


@kernel
def pushed(v: Any, g: Any, e: Any, n: Any, fall: Any, push: float, lighter: float, fall_along: float) -> Any:
    """Return the new velocity of a node of velocity ``v``, from forces ``g`` of the rod, weight and wall.

    All as changes of velocity across; along the channel ``e`` that by forces is ``lighter`` times as large, and that
    by weight is ``fall_along`` more.  ``push`` is against the normal ``n``.
    """
    more = (lighter - 1.0) * dot(g, e) + fall_along * dot(fall, e)
    return (
        v[0] + g[0] + fall[0] + more * e[0] - push * n[0],
        v[1] + g[1] + fall[1] + more * e[1] - push * n[1],
        v[2] + g[2] + fall[2] + more * e[2] - push * n[2],
    )


@kernel
def hold_beside(rod: Any, i: int, place: int) -> None:
    """Return an end that is held across to the curve that its offset describes, which does not wind about the axis."""
    # The curve c + h + run (t + half k), run = (1 - k.h) along: an arc of the axis's curvature, shifted by h.  The node
    # goes to its place on it nearest to where it is, to the third order, and its velocity to its component along the
    # tangent t + along k.
    x, y, z, vx, vy, vz, hold = rod["x"], rod["y"], rod["z"], rod["vx"], rod["vy"], rod["vz"], rod["anchor"]
    t1, t2, t3, k1, k2, k3 = rod["t1"][i], rod["t2"][i], rod["t3"][i], rod["k1"][i], rod["k2"][i], rod["k3"][i]
    h1, h2, h3 = hold[3 * place], hold[3 * place + 1], hold[3 * place + 2]
    c1, c2, c3 = rod["c1"][i] + h1, rod["c2"][i] + h2, rod["c3"][i] + h3
    room = 1.0 - (k1 * h1 + k2 * h2 + k3 * h3)
    along = (t1 * (x[i] - c1) + t2 * (y[i] - c2) + t3 * (z[i] - c3)) / room
    half, run = 0.5 * along, room * along
    x[i], y[i], z[i] = c1 + run * (t1 + half * k1), c2 + run * (t2 + half * k2), c3 + run * (t3 + half * k3)
    e1, e2, e3 = t1 + along * k1, t2 + along * k2, t3 + along * k3
    speed = (vx[i] * e1 + vy[i] * e2 + vz[i] * e3) / (e1 * e1 + e2 * e2 + e3 * e3)
    vx[i], vy[i], vz[i] = speed * e1, speed * e2, speed * e3
