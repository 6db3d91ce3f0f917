# make demo    a humanoid walks in physics and in the browser
# make test    the whole test suite
# make lint    style, types and which room may import which
# make docs    the documentation site, in out/site
# make dist    the source distribution and the wheel, in dist/, with their metadata checked
# make wheel   the wheel alone in an empty environment
# make clean   remove the environment and everything that was built
#
# Needed beforehand: Python 3.10 or newer, pip and make. Everything else goes into .venv.
#   make PYTHON=python3.12 test     another interpreter
#   make test ARGS="-k walk"        some tests; ARGS="-n 0" runs them one after the other
#   make test ARGS="-m slow"        the slow tests, which CI runs besides (7 minutes)

PYTHON ?= python3
ARGS ?=
BIN := .venv/bin
# Modules are compiled when they are first imported: most of what is installed never is.
INSTALL := $(BIN)/python -m pip install --quiet --disable-pip-version-check --no-compile

# Where it is set, each process that a test starts would compile all modules of wbc anew.
unexport PYTHONDONTWRITEBYTECODE

.DEFAULT_GOAL := help
.PHONY: help demo test kernels lint format docs dist wheel install clean

help:
	@sed -n '/^$$/q; s/^# \{0,1\}//p' Makefile

demo: .venv/run.stamp
	$(BIN)/wbc walk --tour --real-time --html out/demo.html

# On two cores the third process runs while the tests of another one wait.
test: .venv/dev.stamp
	$(BIN)/python -m pytest -n 3 --no-loadscope-reorder $(ARGS)

# The tests begin with this; CI does it while it checks other things.
kernels: .venv/dev.stamp
	$(BIN)/python tests/tools/compile_kernels.py

lint: .venv/dev.stamp
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

format: .venv/dev.stamp
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

docs: .venv/dev.stamp
	$(BIN)/python -m sphinx -q -W --keep-going -b html -d out/doctrees docs out/site
	@echo "open out/site/index.html"

dist: .venv/dev.stamp
	rm -rf dist
	$(BIN)/python -m build --outdir dist .
	$(BIN)/python -m twine check --strict dist/*

# It is imported from another folder: here the sources would take its place.
wheel: dist
	rm -rf out/wheel
	$(BIN)/python -m venv out/wheel
	$(INSTALL:$(BIN)/%=out/wheel/bin/%) dist/wbc-*.whl
	out/wheel/bin/python -m pip check
	cd out && wheel/bin/python -c "import wbc; print(wbc.load('simple_humanoid').name, wbc.load('talos').nv)"
	out/wheel/bin/wbc robots > /dev/null

install: .venv/dev.stamp

# Debian's Python may lack ensurepip: then the pip that is there fills the environment. One that is
# two years old takes twice as long to install what follows.
.venv/made.stamp:
	@$(PYTHON) -c 'import sys; sys.version_info >= (3, 10) or sys.exit("wbc needs Python 3.10 or newer, this is " + sys.version.split()[0] + "; say which:  make PYTHON=python3.11 ...")'
	$(PYTHON) -m venv --clear .venv || { \
	  $(PYTHON) -m venv --clear --without-pip .venv && \
	  $(PYTHON) -m pip --python $(BIN)/python install --quiet pip; }
	$(INSTALL) --upgrade pip
	@touch $@

.venv/run.stamp: .venv/made.stamp pyproject.toml
	@echo "installing wbc and what it needs into .venv: once, a minute or so"
	$(INSTALL) -e '.[all]'
	@touch $@

.venv/dev.stamp: .venv/made.stamp pyproject.toml
	@echo "installing wbc, what it needs and the tools for tests and checks into .venv: once, a minute or so"
	$(INSTALL) -e '.[all,dev]'
	@touch .venv/run.stamp $@

clean:
	rm -rf .venv build dist out *.egg-info .mypy_cache .ruff_cache .pytest_cache .hypothesis
	find wbc tests examples benchmarks -name __pycache__ -prune -exec rm -rf {} +
