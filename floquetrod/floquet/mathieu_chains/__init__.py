"""Mathieu's equation by the four chains of Hill's matrix: one theorem, five counts and two determinants.

In the form y'' + (a - 2 q cos 2 z) y = 0, q >= 0, Hill's infinite matrix splits by symmetry into four real symmetric
tridiagonal chains, whose rows and couplings the head of `mathieu_counts` lists.  Their eigenvalues are the
characteristic values; solutions are bounded where an odd number of them lies below a, and none at it (DLMF 28.2, 28.4).

All files run down the same pivots d_k = D_k - a - q^2 / d_(k-1), and stop by the same rule: once d_k > q and
D_j - a >= 2 q for all later j, no later pivot is negative.  They differ in their numbers, and in what may be answered:

`mathieu_counts`
    Doubles rounded to the nearest, 32 points side by side: 8 times as fast as one by one, for arrays of millions of
    points.  The count is right unless a is on a transition curve to rounding.
`certain_count`
    Pairs of doubles rounded outwards, interpreted: a proved count or None, and the pivots it took.  For the method
    ``spectral`` on one equation, which must not wait for a compiler.
`box_count`
    Pairs of doubles rounded outwards, compiled; rows are multiplied by omega^2 / 4, since in a box of loads nothing may
    be divided by an omega that varies.  A proved count, or -1.
`enclosed_counts`
    Intervals of many digits, for `floquetrod.certify`, whose parameters are fractions: a proved count with the pivots
    closest to zero, or `Unresolved`.
`truncated_determinant`
    Doubles, and minors in place of pivots: the value of a determinant, its count and its errors.  For the method
    ``determinant``, which may cut off where the published study does.

`mathieu_determinants` and `mathieu_tail` compute the four determinants of the infinite chains in doubles, for the
discriminant in `floquetrod.floquet.kernels.mathieu_discriminant`.  The rounding is part of each proof and the
order of operations part of each speed, so that one loop for all kinds of numbers would be neither.
"""
