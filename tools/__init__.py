"""What checks a release: `make dist`, `make compatibility`.

A release is made from a clean checkout of the main branch, with VERSION in `floquetrod/_util/version.py`, in the top
entry of `CHANGELOG.md` with today's date instead of "unreleased", and in `CITATION.cff` with `date-released`:

    make test slow docs
    make compatibility WHOLE=--whole
    git tag -a vVERSION -m "floquetrod VERSION"
    python -m twine upload dist/*

`docs/paper/paper.md` is the paper on the package, in the form of the Journal of Open Source Software.

Then the next version gets its entry, "unreleased", and `CITATION.cff` loses its date.
"""
