# Tauto: `make sail` sets up and sails, `make test` sets up and checks. `make help` lists the rest.

SHELL := /bin/bash
.SHELLFLAGS := -eu -o pipefail -c
.DELETE_ON_ERROR:
.DEFAULT_GOAL := help
.PHONY: help sail graph test lint coverage docs wheels bench trial stress soak clean docs-version setup setup-dev environment FORCE

SCENE ?= measured
PASSAGE ?= portsmouth_jamaica
SPEED ?= 60
JOBS ?= 2
MINUTES ?= 60
LOGS ?= ../shared/data/logbooks/logbooks.csv.gz
TRIAL ?=
BENCH ?= --budget 1.2
VERSIONS ?= dist/docs

TAUTO := .venv/bin/tauto
# The passage with a quarter of the samples takes less time, and ends within a mile.
COARSER := --set ship.rate=2 --set solver.tolerance=1e-6
NAME := $(notdir $(basename $(SCENE)))
OUT := bags/out/$(NAME)
SETUP_FILES := $(wildcard src/*/setup.py src/*/setup.cfg src/*/pyproject.toml)

# The wheels bring their own ROS; parts of a sourced one beside it do not load. So the children of
# make see no ROS but theirs.
ROS_VARIABLES := $(strip $(foreach v,ROS_DISTRO ROS_VERSION ROS_PYTHON_VERSION AMENT_PREFIX_PATH \
  COLCON_PREFIX_PATH CMAKE_PREFIX_PATH RMW_IMPLEMENTATION,$(if $($(v)),$(v))))
ROS_PREFIXES := /opt/ros $(subst :, ,$(AMENT_PREFIX_PATH) $(COLCON_PREFIX_PATH))
SPACE := $(subst ,, )
without_ros = $(subst $(SPACE),:,$(strip $(filter-out \
  $(ROS_PREFIXES) $(ROS_PREFIXES:%=%/%),$(subst :, ,$(1)))))
ROS_PATHS := $(strip $(foreach v,PYTHONPATH LD_LIBRARY_PATH,\
  $(if $(filter-out $(call without_ros,$($(v))),$($(v))),$(v))))
CLEARED := $(strip $(ROS_VARIABLES) $(ROS_PATHS))
unexport _ROS_WHEELS_BOOTSTRAP_COMPLETE $(ROS_VARIABLES)
ifneq ($(ROS_PATHS),)
$(foreach v,$(ROS_PATHS),$(eval export $(v) := $(call without_ros,$($(v)))))
endif

help:  ## list the targets
	@sed -n 's/^\([a-z-]*\):.*  ## /\1\t/p' $(MAKEFILE_LIST) | expand -t 12
	@echo 'Variables: SCENE=$(SCENE) PASSAGE=$(PASSAGE) SPEED=$(SPEED) (or max) JOBS=$(JOBS) BENCH="$(BENCH)" LOGS=$(LOGS) MINUTES=$(MINUTES) VERSIONS=$(VERSIONS) PYTHON=...'

sail: graph  ## ten minutes at sea as a ROS 2 graph, then the passage to Jamaica offline
	$(TAUTO) sail $(PASSAGE) $(COARSER)

graph: setup  ## the ROS 2 graph alone: SCENE=name or file, SPEED=sea seconds per second or max
	$(TAUTO) graph $(SCENE) --speed $(SPEED) --out $(OUT) --force

lint: setup-dev  ## format, lint, types, layers, the text of the pages
	.venv/bin/ruff format --check .
	.venv/bin/ruff check .
	.venv/bin/mypy
	.venv/bin/lint-imports --no-logo
	.venv/bin/python -m pytest --quiet tests/lint_prose.py

# Also where the user's Python keeps no bytecode: each of the hundreds of processes that tests start
# would compile the packages again, and pytest its assertions.
test coverage: export PYTHONDONTWRITEBYTECODE :=

# By file: what its tests share is made once, kernels above all. In the order of tests/conftest.py:
# xdist's own begins with the files of most tests, and ends with the longest.
test: lint  ## lint and every test
	.venv/bin/python -m pytest -n $(JOBS) --dist loadfile --no-loadscope-reorder

coverage: setup-dev  ## which lines the tests run: a table, and coverage.xml
	.venv/bin/python -m pytest -n $(JOBS) --dist loadfile --no-loadscope-reorder \
	  --cov=tauto_core --cov=tauto_nodes --cov-report=term:skip-covered --cov-report=xml

docs: setup-dev  ## the documentation site, into site/; a broken link or reference ends it
	.venv/bin/python docs/command_line.py > docs/cli.md
	.venv/bin/python docs/parameters.py > docs/parameters.md
	.venv/bin/python docs/topics.py > docs/topics.md
	.venv/bin/python -m tauto_core.scene.reference > docs/scenes.md
	$(TAUTO) euler --site docs/papers
	$(TAUTO) report portsmouth_jamaica -o docs/demo.html
	.venv/bin/python -m nbconvert --log-level ERROR --to markdown --execute docs/lessons/*.ipynb
	.venv/bin/zensical build --strict --clean

docs-version: docs  ## the site as a version in VERSIONS=folder, with a switch between all that are there
	.venv/bin/python docs/versions.py '$(VERSIONS)'

wheels: setup-dev  ## both packages as wheels and sdists, into dist/; the same bytes each time
	.venv/bin/python -m pip install --quiet 'build>=1.2' 'twine>=6.1'
	.ci/dist

bench: setup  ## the eight clocks of the comparison, messages per second, run time against error
	.venv/bin/python docs/outputs.py --clocks
	.venv/bin/python benchmarks/graph_throughput.py
	.venv/bin/python -m pip install --quiet -r benchmarks/requirements.txt
	.venv/bin/python -m benchmarks.work_precision $(BENCH) --first --passage --page docs/speed.md \
	  --plot docs/img/work_precision.svg --json \
	  > benchmarks/work_precision.json.new
	mv benchmarks/work_precision.json.new benchmarks/work_precision.json

# Euler's involute with a weight, and four other clocks, in one sea each; then the page, docs/trial.md.
# TRIAL="--sample 12" sails fewer. Of one that was ended early `docs/trial.py` alone makes the page.
trial: $(LOGS) setup-dev  ## five clocks on the passages of a log-book, LOGS=file, and the page of it
	mkdir -p bags/out
	$(TAUTO) fleet esperance_to_the_cape --logs '$(LOGS)' --accuracy 1e-3 --jobs $(JOBS) \
	  --compare clock_cheek_weight,clock_own_cam_weight,clock_second_cam_force,clock_own_cam_spring \
	  --out bags/out/trial $(TRIAL)
	.venv/bin/python docs/trial.py bags/out/trial --logs '$(LOGS)'

$(LOGS):
	@echo 'make trial: there is no log-book $@. Name one with LOGS=…; docs/theory/logbooks.md says where' \
	  'they are had' >&2; exit 2

stress: setup-dev  ## numerical stability, 1e8 oscillations among it; fails if a limit breaks
	.venv/bin/python -m pip install --quiet -e 'src/tauto_core[cad,hull]' 'trimesh>=5.2'
	.venv/bin/python benchmarks/stress.py
	TAUTO_GARBAGE=10000 .venv/bin/python -m pytest tests/nodes/live/test_nodes_faults.py -k garbage
	.venv/bin/python -m pytest tests/core/plots/test_solids.py

soak: setup  ## a voyage of MINUTES=60 flat out: memory flat, nothing lost, the bag whole
	.venv/bin/python benchmarks/soak.py --minutes $(MINUTES)

clean:  ## remove bags/out, dist, site, colcon's folders and caches; .venv stays
	rm -rf bags/out coverage.xml dist docs/{cli,parameters,scenes,topics}.md docs/demo.html \
	  docs/lessons/*.md docs/lessons/*_files docs/papers site ros_ws/build ros_ws/install ros_ws/log \
	  .mypy_cache .pytest_cache .ruff_cache .hypothesis .import_linter_cache
	find src tests benchmarks -name __pycache__ -type d -prune -exec rm -rf {} +

setup: environment .venv/.installed

setup-dev: environment .venv/.installed-dev

environment:
	@$(if $(CLEARED),echo 'A sourced ROS is hidden from what follows; cleared: $(CLEARED)',:)

# A stamp holds the folder it was made in: a moved tree is set up anew.
$(foreach s,.installed .installed-dev,$(if $(filter $(CURDIR),$(shell cat .venv/$(s) 2>&1)),,\
  $(eval .venv/$(s): FORCE)))

.venv/.installed: $(SETUP_FILES)
	@$(call install,-e src/tauto_core -e 'src/tauto_nodes[ros]')

.venv/.installed-dev: $(SETUP_FILES)
	@$(call install,-e 'src/tauto_core[dev]' -e 'src/tauto_nodes[ros]')
	@echo '$(CURDIR)' > .venv/.installed

define install
.ci/venv $(PYTHON)
echo 'Installing from PyPI into .venv: a minute or two on a good line.'
.venv/bin/python -m pip install --quiet $(1)
echo '$(CURDIR)' > $@
endef
