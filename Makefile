# make demo   set up what is missing, then a picture, its cousins and a scene to turn, in two minutes
# make all    the same set-up, then the whole workflow
# make test   the same set-up, then lint, types and tests
.DEFAULT_GOAL := help
CORES ?= 2
CLUSTER ?= tests/cluster
IN ?= .
COMMIT ?= $(shell git describe --always --dirty --exclude "*")
BIN := .venv/bin
STAMP := .venv/.installed

# One word for the shell, whatever is in it; a flag with a variable's value as it was typed, if it was given.
quoted = '$(subst ','\'',$(1))'
typed = $(if $(value $(2)),$(1) $(call quoted,$(value $(2))))
HERE := $(call quoted,$(CURDIR))
FOLDER := $(call quoted,$(IN))

# A study in a folder that holds results/ (IN), which finds committed assets in config/; its tables, with the commit that they name.
RUN := $(BIN)/snakemake --cores $(CORES) --keep-going --directory $(FOLDER) --configfile config.yaml
RESULTS := $(BIN)/python -m roomkin.plugins.studies results --results $(FOLDER)/results --benchmarks $(FOLDER)/benchmarks --commit "$(COMMIT)" --configs config.yaml
# Table 3 by config/study/roles.yaml, on and on after what fails.
STUDY := -$(RUN) config/study/table3.yaml config/study/roles.yaml --
SETS := twin cousins_8 cousins_2 cousins_4 all
cells = $(foreach policy,$(1),$(foreach set,$(2),results/evaluation/policies/$(policy)/$(set)/rollouts.csv))

.PHONY: help no-picture setup ready check site wheel demo all table3 table3-object unseen registered table2 paper folder weights picture test verify slurm test-cluster lint types config reference lock containers clean
help: ## list the commands
	@grep -hE '^[a-z0-9-]+:.*## ' $(MAKEFILE_LIST) | sed -E 's/:[^#]*## /\t/' | expand -t 14

setup: $(STAMP) ## create .venv from the pinned requirements, make sure a Vulkan device exists
	@$(BIN)/python -m roomkin.plugins.ops.doctor --mend

ready: $(STAMP)
	@$(BIN)/python -m roomkin.plugins.ops.doctor --mend --brief

check: $(STAMP) ## what this machine has and lacks, and what mends it
	@$(BIN)/python -m roomkin.plugins.ops.doctor

$(STAMP): envs/requirements.txt envs/setup.sh pyproject.toml
	@bash envs/setup.sh
	@touch $@

demo: ready ## a picture, its cousins and a scene to turn, in two minutes
	@$(BIN)/python -m roomkin demo --cores $(CORES)

all: ready ## run the default workflow: library, scenes, policies, tables, report
	$(BIN)/snakemake --cores $(CORES) all

table3: ready folder ## Table 3, Figures 4 and 9 as the paper has them, in four hours on two cores
	$(STUDY) $(call cells,door/lite,$(SETS))
	$(STUDY) $(call cells,drawer/lite,$(SETS))
	$(STUDY) table3
	$(RESULTS) config/study/table3.yaml config/study/roles.yaml --out docs/results

table3-object: ready folder ## the same where policies see the whole object, as the paper's do, in a folder of its own (IN): six hours
	-$(RUN) config/study/table3.yaml config/study/roles.yaml config/study/object_cloud.yaml -- table3
	$(RESULTS) config/study/table3.yaml config/study/roles.yaml config/study/object_cloud.yaml --out docs/results/object

unseen: ready folder ## success over unseen assets, in an hour or two on two cores
	$(RUN) config/study/table3.yaml config/study/over_assets.yaml -- table3
	$(RESULTS) config/study/table3.yaml config/study/over_assets.yaml --out docs/results/unseen

registered: ready ## the registered study of docs/results/design.md: two nights of two cores; it goes on where it stopped
	PATH=$(HERE)/$(BIN):$$PATH CORES=$(CORES) bash config/study/registered.sh

table2: ready weights folder ## Table 2 and Figure 6 with every row, on the eight rooms and their robustness variants
	$(RUN) config/study/table2.yaml -- table2 table2_robustness
	$(RESULTS) config/study/table2.yaml --table 2 --variants b ours-geometry --out docs/results

paper: ready ## every figure of docs/results by one commit, but what is pinned in its machines.md: a day of two cores; it goes on where it stopped
	PATH=$(HERE)/$(BIN):$$PATH CORES=$(CORES) snakemake --cores $(CORES) --keep-going --snakefile plugins/studies/paper.smk --directory results/paper

folder:
	@[ $(FOLDER) = . ] || { mkdir -p $(FOLDER) && ln -sfn $(HERE)/config $(FOLDER)/config; }

weights: $(STAMP) ## fetch the weights of the four networks that look at pictures, 300 MB, once; a line says if that fails
	@$(BIN)/python -m roomkin.stages.perception fetch

picture: $(if $(RGB),ready,no-picture) ## a photograph of yours, e.g. make picture RGB=kitchen.jpg; with depth: DEPTH=depth.png INTRINSICS=camera.json; RGB=FOLDER: all frames of a recording
	@$(BIN)/python -m roomkin picture --cores $(CORES) $(call typed,,RGB) $(call typed,--depth,DEPTH) $(call typed,--intrinsics,INTRINSICS)

no-picture:
	@echo "error: no picture is named. Fix: make picture RGB=kitchen.jpg" >&2; exit 1

test: ready lint types ## lint, types and all tests; Chromium for those of the report page
	@bash envs/chromium.sh
	PYTEST_DISABLE_PLUGIN_AUTOLOAD=1 $(BIN)/python -m pytest -p xdist -n $(CORES) --dist loadfile --no-loadscope-reorder

site: $(STAMP) ## the documentation as a site, with every link checked: site/index.html
	bash envs/docs.sh

wheel: $(STAMP) ## the package for pip, and its source: dist/
	$(BIN)/uv build --quiet --offline --no-build-isolation --python $(BIN)/python --out-dir dist

slurm: $(STAMP) ## the executor plugin that profiles/slurm needs
	VIRTUAL_ENV=.venv $(BIN)/uv pip install --quiet --require-hashes -r envs/slurm.txt

test-cluster: ready slurm ## the workflow on a real SLURM of two nodes on this machine, and its faults; installs SLURM (as root)
	bash envs/slurm.sh
	$(BIN)/python -m pytest -m cluster $(CLUSTER)

verify: $(STAMP) ## are all files of results/ as the run left them? what is broken, and what makes it anew; IN: another folder
	@$(BIN)/python -m roomkin.plugins.ops verify --results $(FOLDER)/results

lint: $(STAMP) ## ruff, snakefmt, snakemake --lint
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/snakefmt --check Snakefile rules plugins
	$(BIN)/snakemake --lint

types: $(STAMP) ## mypy
	$(BIN)/mypy

config: $(STAMP) ## write config/schema.json and docs/config.md from the typed models
	$(BIN)/python -m roomkin.stages.config

reference: $(STAMP) ## write docs/architecture.md and its pictures from the code
	$(BIN)/python -m reference

lock: $(STAMP) ## pin the newest versions that pyproject.toml allows
	BIN=$(BIN) bash envs/lock.sh

containers: $(STAMP) ## build an image with podman and run a real rule in it
	bash containers/check.sh

clean: ## delete everything a run wrote; the environment stays, and what you drew and corrected (hand/)
	@$(BIN)/python -m roomkin.plugins.ops clean
