# One command each; `make help` lists them.  Everything is installed into $(VENV) and web/node_modules, nothing outside (but
# Chromium and nginx for the tests, from the system's packages, when there are none).  Plain make: no GNU extensions.
PYTHON ?= python3
VENV ?= .venv
PORT ?= 8321

# Run with the environment's own programs first: a Node that came from PyPI lives there too.
IN_VENV = PATH="$$(cd "$(VENV)/bin" && pwd):$$PATH"

help:
	@echo "make serve   build the page and serve it at http://127.0.0.1:$(PORT)/?token=...   (PORT=... DATA=... to change)"
	@echo "make test    everything that must hold: check, unit tests of page and package, browser test"
	@echo "make check   lint and types only"
	@echo "make room    ROOM=rig: lint, types and quick tests of one room of the package   (TESTS=tests/rig: all; TESTS=tests/fitting/test_stance.py: only these)"
	@echo "make mutants wrong changes that no test of a numeric room sees   (MUTANTS=\"drawings report --count 40 --seed 1\")"
	@echo "make cohort  solve women under gravity and estimate what it does to breasts   (WOMEN=400 COHORT=data/gravity)"
	@echo "make docs    build the documentation into dist/docs; warnings are errors"
	@echo "make bench   measure the hot paths   (BENCH=--benchmark-timer=time.process_time where other work runs)"
	@echo "make fuzz    many made-up files and requests: a table of what each reader and call did   (FUZZ=20: two hundred times as many as in make test)"
	@echo "make scale   the service with a Dask cluster as well, a killed server and worker among it"
	@echo "make faults  kill, fill, lock and leave: a table of what became of every fit   (KILLS=20)"
	@echo "make load    clients that work, viewers, and readers of a large scan through a link: times, memory, errors   (LOAD=\"--seconds 60\")"
	@echo "make routes  every route with every credential: a table of status codes; two share links in two tabs of one browser"
	@echo "make wheelhouse all wheels with their hashes in dist/wheelhouse, for an installation without a network"
	@echo "make sbom    the components of that wheelhouse as CycloneDX, dist/sbom.cdx.json"
	@echo "make audit   known holes of those components, asked of PyPI"
	@echo "make clean   remove what make made (data stays)"

serve: page $(VENV)/.stamp-serve
	@exec "$(VENV)/bin/breastrig" serve --host 127.0.0.1 --port "$(PORT)" $${DATA:+--data "$$DATA"}

# Side by side, for each of them leaves a core idle half of the time; what they install and build is there before: two
# installations at once are in each other's way.
test: page packages programs
	@"$(VENV)/bin/python" .ci/run_targets.py "$(MAKE)" check vitest pytest browser

check: web-packages $(VENV)/.stamp-test
	"$(VENV)/bin/ruff" check .
	"$(VENV)/bin/ruff" format --check .
	"$(VENV)/bin/mypy"
	"$(VENV)/bin/lint-imports" --no-cache
	$(IN_VENV) npm --prefix web run --silent typecheck
	$(IN_VENV) npm --prefix web run --silent lint

# The inner loop: one room of server/breastrig, with its tests apart from those marked slow (what --durations=0 shows of
# those that make whole fits), or with those that are named (a file, a folder, several).
TESTS = -m "not slow and not soak" tests/$(ROOM)
room: $(VENV)/.stamp-test
	@{ [ -n "$(ROOM)" ] && [ -f "server/breastrig/$(ROOM)/__init__.py" ] && [ -d "tests/$(ROOM)" ]; } || \
	    { echo "error: say which room: make room ROOM=fitting; there are" $$(cd server/breastrig && for room in */; do \
	    [ -d "../../tests/$$room" ] && echo "$${room%/}"; done) >&2; exit 2; }
	"$(VENV)/bin/ruff" check "server/breastrig/$(ROOM)" "tests/$(ROOM)"
	"$(VENV)/bin/ruff" format --check "server/breastrig/$(ROOM)" "tests/$(ROOM)"
	"$(VENV)/bin/mypy" --package "breastrig.$(ROOM)"
	@said="$$("$(VENV)/bin/lint-imports" --no-cache)" || { echo "$$said"; exit 1; }
	OPENBLAS_NUM_THREADS=1 "$(VENV)/bin/python" -m pytest -q -n 2 $(TESTS)

# What gravity does to breasts: hours on two cores; an interrupted run goes on where it was.
COHORT = data/gravity
cohort: $(VENV)/.stamp-test
	OPENBLAS_NUM_THREADS=1 "$(VENV)/bin/python" model_assets/make_gravity.py "$(COHORT)" $${WOMEN:+--women "$$WOMEN"}
	"$(VENV)/bin/python" -m breastrig_studies.gravity.estimate "$(COHORT)"

docs: $(VENV)/.stamp-docs
	"$(VENV)/bin/sphinx-build" -W --keep-going -q -b html docs dist/docs

vitest: web-packages
	$(IN_VENV) npm --prefix web test

# As many processes as cores, at most four: each takes 12 s to import what it tests, and what waits leaves room for the
# browser's tests beside them.  Python keeps what it has compiled, whatever the surroundings say: else each of the hundreds of programs that are started compiles all of ours.
pytest: page $(VENV)/.stamp-test
	cores="$$(getconf _NPROCESSORS_ONLN)"; [ "$$cores" -lt 4 ] || cores=4; \
	BREASTRIG_NGINX="$$(sh .ci/nginx.sh)" && export BREASTRIG_NGINX && \
	    PYTHONDONTWRITEBYTECODE= OPENBLAS_NUM_THREADS=1 $(IN_VENV) "$(VENV)/bin/python" -m pytest -n "$$cores" --dist loadfile --no-loadscope-reorder \
	    -m "not soak" # they are in `make faults`, `make scale` and `make load`

browser: page web-packages $(VENV)/.stamp-test
	BREASTRIG_CHROMIUM="$$(sh .ci/chromium.sh)" && export BREASTRIG_CHROMIUM && \
	    TMPDIR="$$("$(VENV)/bin/python" tests/helpers/temporary.py)" && export TMPDIR && \
	    PYTHONDONTWRITEBYTECODE= $(IN_VENV) npm --prefix web run e2e

# The same tests as in `make test`, with many more cases, other ones each time.
fuzz: $(VENV)/.stamp-test
	OPENBLAS_NUM_THREADS=1 BREASTRIG_FUZZ="$${FUZZ:-20}" PYTHONPATH=tests "$(VENV)/bin/python" -m pytest -q -p helpers.fuzz_table \
	    tests/scan/test_fuzz.py tests/scan/test_fuzz_inside.py tests/scan/test_fuzz_glb.py tests/scan/test_fuzz_places.py \
	    tests/gltf/test_fuzz_rig.py tests/use/test_fuzz_bodies.py tests/api/test_fuzz_http.py tests/fitting/test_robustness.py

faults: $(VENV)/.stamp-test
	OPENBLAS_NUM_THREADS=1 BREASTRIG_KILLS="$${KILLS:-20}" BREASTRIG_FAULT_TABLE=1 "$(VENV)/bin/python" -m pytest -q tests/faults

scale: $(VENV)/.stamp-test
	OPENBLAS_NUM_THREADS=1 "$(VENV)/bin/python" -m pytest -q tests/scale

load: $(VENV)/.stamp-test
	OPENBLAS_NUM_THREADS=1 PYTHONPATH=tests "$(VENV)/bin/python" -m load $${LOAD}
	OPENBLAS_NUM_THREADS=1 "$(VENV)/bin/python" -m pytest -q tests/load

routes: page web-packages $(VENV)/.stamp-test
	BREASTRIG_ROUTE_TABLE=1 "$(VENV)/bin/python" -m pytest -q tests/api/test_route_walk.py
	BREASTRIG_CHROMIUM="$$(sh .ci/chromium.sh)" && export BREASTRIG_CHROMIUM && \
	    BREASTRIG_ROUNDS="$${ROUNDS:-20}" $(IN_VENV) npm --prefix web run e2e -- two_links

mutants: $(VENV)/.stamp-test
	"$(VENV)/bin/python" tests/mutants.py $${MUTANTS:---count 40}

bench: $(VENV)/.stamp-test
	OPENBLAS_NUM_THREADS=1 "$(VENV)/bin/python" -m pytest tests/benchmarks --benchmark-only --benchmark-columns=min,median,rounds --benchmark-sort=name $${BENCH}

wheelhouse: page
	"$(VENV)/bin/python" server/packaging/wheelhouse.py dist/wheelhouse

sbom: $(VENV)/.stamp-release
	@[ -f dist/wheelhouse/requirements.txt ] || { echo "error: make wheelhouse first" >&2; exit 2; }
	"$(VENV)/bin/cyclonedx-py" requirements dist/wheelhouse/requirements.txt --output-file dist/sbom.cdx.json

audit: $(VENV)/.stamp-release
	@[ -f dist/wheelhouse/requirements.txt ] || { echo "error: make wheelhouse first" >&2; exit 2; }
	@grep -v "^breastrig==" dist/wheelhouse/requirements.txt > dist/audited.txt
	@"$(VENV)/bin/pip-audit" --requirement dist/audited.txt --disable-pip --require-hashes --strict --progress-spinner off || \
	    { echo "error: pip-audit found a hole, or could not ask of each component: its last line says which" >&2; exit 1; }

clean:
	rm -rf "$(VENV)" web/node_modules web/dist dist .mypy_cache .ruff_cache .hypothesis

# The page is rebuilt only when its sources changed: build_page.py compares contents, so it always runs, and is quick.
page: $(VENV)/.stamp-venv
	@"$(VENV)/bin/python" server/packaging/build_page.py

packages: web-packages $(VENV)/.stamp-test

# What the tests need of the system's packages.
programs:
	@sh .ci/chromium.sh >/dev/null && sh .ci/nginx.sh >/dev/null

web-packages: $(VENV)/.stamp-venv
	@"$(VENV)/bin/python" server/packaging/build_page.py --packages

$(VENV)/.stamp-venv:
	@"$(PYTHON)" -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	    { echo "error: BreastRig needs Python 3.11 or later; say which with: make PYTHON=python3.11" >&2; exit 1; }
	"$(PYTHON)" -m venv "$(VENV)"
	@touch "$@"

$(VENV)/.stamp-serve: $(VENV)/.stamp-venv pyproject.toml
	$(IN_VENV) "$(VENV)/bin/python" -m pip install -qq --disable-pip-version-check --editable ".[server,mri,volume]"
	@touch "$@"

$(VENV)/.stamp-test: $(VENV)/.stamp-venv pyproject.toml
	$(IN_VENV) "$(VENV)/bin/python" -m pip install -qq --disable-pip-version-check --editable ".[test]"
	@touch "$@" "$(VENV)/.stamp-serve"

$(VENV)/.stamp-docs: $(VENV)/.stamp-venv pyproject.toml
	$(IN_VENV) "$(VENV)/bin/python" -m pip install -qq --disable-pip-version-check --editable ".[docs]"
	@touch "$@"

$(VENV)/.stamp-release: $(VENV)/.stamp-venv pyproject.toml
	$(IN_VENV) "$(VENV)/bin/python" -m pip install -qq --disable-pip-version-check "cyclonedx-bom>=7,<8" "pip-audit>=2.9,<3"
	@touch "$@"

# Two recipes must not install into the same folder at once, whatever -j says.
.NOTPARALLEL:
.PHONY: help cohort mutants serve test check room docs vitest pytest browser fuzz faults scale load routes bench clean page packages programs sbom audit wheelhouse web-packages
