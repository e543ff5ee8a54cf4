# From a fresh machine with python3 (3.11 or newer) and make: `make demo`, `make test`; `make help` lists all.
PYTHON ?= python3
WORKERS ?= 2
# `make fuzz SEEDS=5`: how many seeds every attack is run from.
SEEDS ?= 1
# `make compatibility PYTHONS="python3.12 python3.13" WHOLE=--whole`: those not found are left out; the whole quick suite.
PYTHONS ?= python3.11 python3.12 python3.13 python3.14
WHOLE ?=

VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready
DOCS_READY := $(VENV)/.docs-ready
DIST_READY := $(VENV)/.dist-ready
# What is imported is compiled to bytecode then: of all that is installed, a third.
INSTALL := $(BIN)/python -m pip install --quiet --disable-pip-version-check --no-compile -c constraints.txt -e
# Hypothesis and pytest write their own caches; worksteal keeps both workers busy to the end.  Each has a core of its own,
# which a second thread of OpenBLAS would take from the other.
PYTEST := OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest -n $(WORKERS) --dist worksteal
# Tests marked "kernels" reach every kernel.  They run once more interpreted, where a kernel is seen to be the Python it
# is written in and every index is checked; with `make slow` compiled with every index checked, too.
# More examples, of every test that draws some.
DEEP := FLOQUETROD_TEST_DEPTH=deep

# Workers and child processes load what was compiled to bytecode once, whatever the shell says.
unexport PYTHONDONTWRITEBYTECODE

.DELETE_ON_ERROR:
.PHONY: demo help test quick interpreted lint slow bite fuzz coverage bench agreement reproduce docs pages look dist compatibility clean

demo: $(READY)  ## a verdict and a map of the reference rod
	@$(BIN)/floquetrod check --rod nitinol --mean 0.2Fcr --amplitude 0.2Fcr --frequency 150rad/s
	@echo
	@$(BIN)/floquetrod map --rod nitinol --mean 0:1.1Fcr --amplitude 0.2Fcr --frequency 20:200rad/s --growth \
		--growth-tolerance 0.1 --mark 0.2Fcr,150rad/s --out demo_map.png

help:  ## this list
	@sed -n 's/^\([a-z]*\):.*  ## /\1\t/p' $(MAKEFILE_LIST) | expand -t 16

# Types are checked on one processor while the tests run, which wait for nothing: both are busy to the end.
test: $(READY)  ## lint, types and the suite: minutes
	@$(MAKE) --no-print-directory -j 2 lint quick

quick: interpreted  ## the suite without what is slow, first what runs interpreted
	$(PYTEST) -m "not slow"

interpreted: $(READY)  ## tests of kernels, interpreted
	NUMBA_DISABLE_JIT=1 $(PYTEST) -n 0 -m "kernels and not slow"

lint: $(READY)  ## ruff and mypy
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

# Everything, and what draws examples draws many.
slow: $(DOCS_READY)  ## every test, with many more random examples, and those too slow for every change
	$(DEEP) NUMBA_BOUNDSCHECK=1 $(PYTEST) -m kernels
	$(DEEP) $(PYTEST)

# How often each property was checked, and how often its example was discarded: a property that hardly bites fails.
bite: $(READY)  ## how often each property was checked and its examples discarded; one that is hardly checked fails
	$(PYTEST) -m "not slow" --bite

# The attack on the package, from fresh seeds; `python -m tests.fuzz --help` tells of the options that FUZZ may hold.
fuzz: $(READY)  ## attacks from fresh seeds: SEEDS=5 WORKERS=4 FUZZ="--minutes 60"
	$(BIN)/python -m tests.fuzz --seeds $(SEEDS) --workers $(WORKERS) $(FUZZ)

# Lines of machine code cannot be counted: what reaches the kernels runs interpreted first, then everything quick.
coverage: $(READY)  ## lines the suite reaches, kernels interpreted: at least 95 %
	$(BIN)/python -m coverage erase
	NUMBA_DISABLE_JIT=1 $(PYTEST) -m "kernels and not slow" --cov --cov-report=
	$(PYTEST) -m "not slow" --cov --cov-append --cov-report=term-missing:skip-covered --cov-fail-under=95

# Sphinx takes a warning for an error, and every page and example is run; then all links of the site are followed.
# 130 s of processor time on a processor of 2025 (AMD EPYC, Zen 5), one minute more where the kernels are not yet compiled;
# older processors take two to three times as long.  Under a minute where no code changed: pages and examples are executed
# again only where their own code, the package's or its libraries' versions changed (docs/executed.py).
docs: $(DOCS_READY)  ## the site, all of it executed, into docs/_build/html
	OPENBLAS_NUM_THREADS=1 $(BIN)/python -m sphinx -W --keep-going -T -b html -d docs/_build/doctrees docs docs/_build/html
	$(BIN)/python docs/check_site.py docs/_build/html

# The same pages for those who read them on a forge, from what `make docs` executed or else executed now; after a
# change of prose alone python docs/forge_pages.py --prose takes seconds.
pages: $(DOCS_READY)  ## the pages in docs/pages, plain Markdown with outputs and pictures: after a change of a page
	OPENBLAS_NUM_THREADS=1 $(BIN)/python docs/forge_pages.py

# Every page of that site in a browser, on a desktop, on a phone and in the dark; pictures of all into docs/_build/look.
# Needs a Chromium, on the path or in $CHROMIUM.
look: docs  ## every page of it in a browser, wide, on a phone and in the dark, with what a reader would stumble over
	$(INSTALL) ".[test,docs,site-check]"
	$(BIN)/python docs/look.py docs/_build/html docs/_build/look

bench: $(READY)  ## ratios against what people use today
	$(BIN)/python -m benchmarks --page docs/reference/peers.md

agreement: $(READY)  ## every method against every other
	$(BIN)/python -m benchmarks.agreement

# The published study, recomputed into the folder reproduction: `make reproduce STUDY="--quick --simulations"`.
reproduce: $(READY)  ## the published study recomputed: figures, claims, a report
	$(BIN)/python -m studies $(STUDY)

# The sdist and the wheel in dist/, checked and tried in an empty environment.  Needs git and a network.
dist: $(DIST_READY)  ## sdist and wheel into dist/, checked, and the wheel tried in an empty environment
	$(BIN)/python -m tools.check_dist
	$(BIN)/python -m tools.try_wheel

# The same wheel with every Python found and the oldest and newest dependencies: minutes, with WHOLE=--whole hours.
compatibility: dist  ## the wheel with every Python found, oldest and newest dependencies; WHOLE=--whole: the quick suite
	$(BIN)/python -m tools.try_wheel --pythons $(PYTHONS) --dependencies oldest newest $(WHOLE)

clean:  ## deletes all that was made
	rm -f demo_map.png .coverage
	rm -rf docs/_build docs/gallery docs/reference/commands
	rm -rf $(VENV) .cache .hypothesis .mypy_cache .pytest_cache .ruff_cache build dist
	find floquetrod studies tests benchmarks examples tools -name __pycache__ -prune -exec rm -rf {} +

# Written last, so that a failed or interrupted installation is begun again, from nothing.
$(READY): pyproject.toml constraints.txt
	$(PYTHON) -m venv --clear $(VENV)
	$(INSTALL) ".[test]"
	@touch $@

$(DOCS_READY): $(READY)
	$(INSTALL) ".[test,docs]"
	@touch $@

$(DIST_READY): $(READY)
	$(INSTALL) ".[test,dist]"
	@touch $@
