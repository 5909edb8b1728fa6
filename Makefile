# make run     make the environment, simulate the OC3 spar in wind and waves, draw a picture
# make test    make the environment, run the tests
# make batch-demo  run twelve short cases and write a page about them, output/demo.html
# make setup lint bench docs catalogue verification torture fmus lock clean: see below

PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
STAMP  := $(VENV)/.made-from-lock

.PHONY: setup run batch-demo test lint bench docs catalogue verification torture fmus lock clean

setup: $(STAMP)

# The environment holds exactly the pinned packages, and fowtlib itself in editable form.
$(STAMP): requirements.lock pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(0 if sys.version_info >= (3, 11) else "fowtlib needs Python 3.11 or newer, and $(PYTHON) is " + sys.version.split()[0] + "; try: make PYTHON=python3.11")'
	test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -r requirements.lock
	PYTHONWARNINGS=ignore $(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation --editable .
	touch $(STAMP)

run: $(STAMP)
	@mkdir -p output
	$(BIN)/fowt run oc3_spar_rigid --time 300 --wind kaimal:11.4,class=B,seed=1 --waves jonswap:Hs=6,Tp=10,seed=1 \
		--output output/oc3_spar_rigid.nc --plot output/oc3_spar_rigid.png --force

batch-demo: $(STAMP)
	@mkdir -p output
	$(BIN)/fowt batch run models/cases/demo.yaml --folder output/demo.batch
	$(BIN)/fowt batch report models/cases/demo.yaml --folder output/demo.batch --output output/demo.html --force

# TESTS: further words for pytest, such as TESTS="-k mooring". One thread of linear algebra for each of the workers, which are as
# many as there are cores: threads that wait for each other take several times as long.
test: $(STAMP)
	OPENBLAS_NUM_THREADS=1 OMP_NUM_THREADS=1 $(BIN)/python -m pytest -n auto --dist worksteal $(TESTS)

lint: $(STAMP)
	$(BIN)/ruff check .

# BENCH: further words, such as BENCH="--former COMMIT" for the rows of former.py beside those of an earlier commit.
bench: $(STAMP)
	$(BIN)/python benchmarks/run.py $(BENCH)

docs: $(STAMP)
	$(BIN)/zensical build --strict

# Write docs/catalogue.md from the docstrings and declarations of the components.
catalogue: $(STAMP)
	$(BIN)/fowt parts --markdown > docs/catalogue.md

# The long tests; then compute every table of docs/verification.md and docs/load_cases.md and write them into the pages.
verification: $(STAMP)
	$(BIN)/python -m pytest -m long tests
	$(BIN)/python benchmarks/verification.py
	$(BIN)/python benchmarks/verification_dtu10mw.py
	$(BIN)/python benchmarks/load_cases.py

# Attack: damaged model and data files, kills, full disks, cold caches, threads; fills docs/reliability.md.
# TORTURE: further words, such as TORTURE="--models 1000 --kills 5", see tests/robustness/torture.py.
torture: $(STAMP)
	$(BIN)/python tests/robustness/torture.py $(TORTURE)

# Build the FMUs of fmus/recipes into fmus/built and check each one; `fmus/build.py NAME` does one.
fmus: $(STAMP)
	$(BIN)/python fmus/build.py

# Pin the newest packages that pyproject.toml allows: install them into a fresh environment and write down what came.
lock:
	rm -rf build/lock-venv
	$(PYTHON) -m venv build/lock-venv
	build/lock-venv/bin/python -m pip install --quiet --disable-pip-version-check '.[dev,docs,fmi,hydro,cluster]'
	( echo '# Made by `make lock` from pyproject.toml; every package of the environment, pinned.'; \
	  build/lock-venv/bin/python -m pip freeze --all --exclude fowtlib --exclude pip ) > requirements.lock
	rm -rf build/lock-venv

clean:
	rm -rf $(VENV) .editable build dist site output fmus/built *.egg-info .pytest_cache .ruff_cache
