# Everything is built here from Python 3.11 (or newer), make and pip; nothing else is needed.
PYTHON ?= python3
VENV   ?= .venv
BIN    := $(VENV)/bin
JOB    ?= config/heart.yaml

.PHONY: run test check hil-aarch64 benchmarks clean

run: $(VENV)/.run
	$(BIN)/deltactl run $(JOB)

test: check
	$(BIN)/python -m pytest -n 2 -m "not realtime"
	$(BIN)/python -m pytest -m realtime

check: $(VENV)/.test
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	@# Types are checked against one numpy, that of Python 3.11; numpy 2 has other stubs.
	if $(BIN)/python -c 'import sys; sys.exit(sys.version_info >= (3, 12))'; \
	then $(BIN)/mypy; else echo "mypy: run on Python 3.11 only"; fi

# The hardware-in-the-loop tests once more, on an emulated 64-bit ARM machine.
hil-aarch64:
	tests/hil/aarch64/run $(PYTHON) build/aarch64

benchmarks: $(VENV)/.test
	for file in benchmarks/*.py; do echo "== $$file"; $(BIN)/python $$file || exit 1; done

# The virtual environment is made without ensurepip, which Debian ships separately:
# the system's pip installs into it from outside.
$(VENV)/bin/python:
	$(PYTHON) -m venv --without-pip $(VENV)

$(VENV)/.run: $(VENV)/bin/python pyproject.toml constraints.txt
	$(PYTHON) -m pip --python $(BIN)/python install --quiet --disable-pip-version-check -c constraints.txt -e .
	touch $@

$(VENV)/.test: $(VENV)/bin/python pyproject.toml constraints.txt
	$(PYTHON) -m pip --python $(BIN)/python install --quiet --disable-pip-version-check -c constraints.txt -e '.[diagnosis,training,tables,proof,test]'
	touch $@ $(VENV)/.run

clean:
	rm -rf $(VENV) build *.egg-info .mypy_cache .ruff_cache
