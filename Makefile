# Everything is built here from Python 3.11 (or newer), make and pip; nothing else is needed.
VENV   ?= .venv
# The first Python that has pip: a virtual environment that is activated, ours too, may have none.
HAS_PIP = for each in $$(which -a python3); do \
	if $$each -m pip --version >/dev/null 2>&1; then echo $$each; break; fi; done
PYTHON ?= $(firstword $(shell $(HAS_PIP)) python3)
BIN    := $(VENV)/bin
JOB    ?= config/heart.yaml

# On a PC the diagnosis and the page are installed too; a Raspberry Pi stays small: it runs the robot, and
# recordings are diagnosed elsewhere. `make extras WITH=diagnosis` adds it there. pip alone brings the
# diagnosis to the processors of PCs only (pyproject.toml), and an ARM PC with Linux is none to it.
ON_A_PI := $(shell grep -qs 'Raspberry Pi' /proc/device-tree/model && echo yes)
COMMA   := ,
WITH    ?= $(if $(ON_A_PI),,diagnosis$(COMMA)web)
EXTRAS   = $(if $(WITH),[$(WITH)])
# On a terminal pip shows what it is at and how far; a log is spared that.
QUIET   := $(shell test -t 2 || echo --quiet)
INSTALL  = $(PYTHON) -m pip --python $(BIN)/python install $(QUIET) --disable-pip-version-check -c constraints.txt

.PHONY: run demo extras test test-beside test-clock test-page check style types newcomer studies rivals-ci release-check reference site hil-aarch64 benchmarks clean

run: $(VENV)/.run
	$(BIN)/deltactl run $(JOB)

# Conceals something in a robot, diagnoses and corrects it; the page is demo/demo.html.
demo: $(VENV)/.test
	$(BIN)/deltactl demo

# A test that fails is run once more, and named as RERUN at the end if it passes then: some hold a
# program to the clock of a machine that others use too. Each name there is a defect to look into.
AGAIN := --reruns 1 --reruns-delay 2 -r R
# A file of tests stays with one process: what its tests share is made once.
WORKERS ?= 3
MANY = -n $(WORKERS) --dist loadfile --no-loadscope-reorder
# Two processes on two cores: more threads of the arithmetic libraries only wait for each other.
ONE_THREAD := OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1
# Tests against the clock wait most of the time: the others run beside them, in the time that they
# leave idle. On a machine that does something else, `make test-beside test-clock` runs one after the other.
IDLE  := $(shell chrt --idle 0 true 2>/dev/null && echo chrt --idle 0 || echo nice -n 19)
# Without it every process that a test starts compiles all its modules again.
test test-page: export PYTHONDONTWRITEBYTECODE =
test: export BESIDE := $(IDLE)
test: style
	$(MAKE) --no-print-directory -k -j 2 test-beside test-clock

# A process more than two cores: tests wait for the processes that they start.
test-beside: $(VENV)/.test
	$(ONE_THREAD) $(BESIDE) $(BIN)/python -m pytest $(MANY) -m "not realtime" $(AGAIN)

test-clock: $(VENV)/.test
	$(BIN)/python -m pytest -m realtime --ignore tests/web $(AGAIN)

test-page: $(VENV)/.test
	$(BIN)/python -m pytest -m realtime tests/web $(AGAIN)

check: style types

style: $(VENV)/.test
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(VENV)/.test
	@# Types are checked against one numpy, that of Python 3.11; numpy 2 has other stubs.
	if $(BIN)/python -c 'import sys; sys.exit(sys.version_info >= (3, 12))'; \
	then $(BESIDE) $(BIN)/mypy; else echo "mypy: run on Python 3.11 only"; fi

# The hardware-in-the-loop tests once more, on an emulated 64-bit ARM machine.
hil-aarch64:
	tests/hil/aarch64/run $(PYTHON) build/aarch64

# What docs/figures.md quotes, some minutes.
FIGURES = kinematics network chain servo ranging micro pulse training
benchmarks: $(VENV)/.test
	for name in $(FIGURES); do echo "== $$name"; $(BIN)/python benchmarks/costs/$$name.py || exit 1; done

# The virtual environment is made without ensurepip, which Debian ships separately:
# the system's pip installs into it from outside. On a Pi it sees the system's packages, because
# PyPI has lgpio up to Python 3.12 only, and Debian has python3-lgpio.
SYSTEM := $(if $(ON_A_PI),--system-site-packages)
$(VENV)/bin/python:
	@$(PYTHON) -m venv --without-pip $(SYSTEM) $(VENV)

$(VENV)/.run: $(VENV)/bin/python pyproject.toml constraints.txt
	@echo "Installing deltactl$(EXTRAS) into $(VENV): one to four minutes, the first time."
	@$(INSTALL) -e '.$(EXTRAS)'
	@touch $@

# More parts of the program: make extras WITH=training,proof
extras: $(VENV)/bin/python
	@echo "Installing deltactl$(EXTRAS) into $(VENV): some minutes."
	@$(INSTALL) -e '.$(EXTRAS)'
	@touch $(VENV)/.run

$(VENV)/.test: $(VENV)/bin/python pyproject.toml constraints.txt
	@echo "Installing deltactl with all its parts and the tests into $(VENV): some minutes, the first time."
	@$(INSTALL) -e '.[diagnosis,training,tables,proof,web,fleet,foxglove,mcp,docs,test]'
	@touch $@ $(VENV)/.run

# Pages and JSON Schemas, from the code: docs/reference and schemas.
reference: $(VENV)/.test
	$(BIN)/python -m deltactl.reference.write

# The documentation site, build/site/index.html: no network, no server; a warning fails it.
site: $(VENV)/.test
	$(BIN)/python -m deltactl.reference.site

# What a newcomer types, on a clean clone: every command of README and docs that a PC can run.
newcomer: $(VENV)/.test
	$(BIN)/python -m pytest -m newcomer --timeout 3600 $(AGAIN)

# Studies of the papers and diagnoses of many drawn machines, which take minutes.
# As many processes as cores: a job is planned at a low priority, and waits where all are taken.
studies: WORKERS = 2
studies: $(VENV)/.test
	$(ONE_THREAD) $(BIN)/python -m pytest $(MANY) -m "study and not realtime" --timeout 3600 $(AGAIN)
	$(BIN)/python -m pytest -m "study and realtime" --timeout 3600 $(AGAIN)

# A twentieth of the comparison with other tools; without its second environment, what runs in ours.
rivals-ci: $(VENV)/.test
	$(ONE_THREAD) $(BIN)/python -m benchmarks.rivals --axes 6 --deltas 3 --halves --minutes 1 --out build/rivals/ci \
	  $(if $(wildcard build/rivals/venv/made-from.txt),--arms 2,--here)

# Wheel and sdist: built, checked, installed into empty environments, and tried in each Python there is.
release-check: $(VENV)/.test
	$(ONE_THREAD) $(BIN)/python -m pytest -n 2 -m release --timeout 1800 -r s tests/release

clean:
	rm -rf $(VENV) build *.egg-info .mypy_cache .ruff_cache
