# One command each; what is needed is installed on the way, and only when it is missing.

VENV := .venv
BIN := $(VENV)/bin
# Python itself compiles the tenth of all modules that is ever imported, when it first is.
PIP := $(BIN)/python -m pip --disable-pip-version-check install --quiet --no-compile \
	--constraint constraints.txt
INSTALL := $(PIP) --no-build-isolation --editable

# Shared libraries that Open3D and Pinocchio expect from the system.
LIBRARIES := libusb-1.0-0 libgl1 libegl1 libx11-6 libidn2-0 libgomp1
BROWSER := chromium-headless-shell fonts-dejavu-core

# What stands for devices in the tests: a web server, a camera of GenICam, a PLC; and readers of zip
# files of others.
STAND_INS := apache2-bin aravis-tools mbpoll unzip libarchive-tools p7zip-full

# What `make test` leaves to `make test-all`: what takes longest for what it finds, and the tabs of
# the page by themselves; the cycle through the page stays.  Single tests of other files have the
# mark `extensive`.
EXTENSIVE := app/calibration/test_next_pose.py app/core/test_any_sequence.py \
	app/emptying/test_bound.py app/filling/test_fill.py \
	app/picking/test_regrasp.py app/runtime/test_ahead.py app/runtime/test_killed.py \
	browser/test_axe.py browser/test_calibration_tab.py browser/test_cancelling.py \
	browser/test_cell_tab.py browser/test_changes.py browser/test_control.py \
	browser/test_emptying_tab.py browser/test_filling.py browser/test_foreign_tab.py \
	browser/test_front_door.py browser/test_getting_ready.py browser/test_grasps_tab.py \
	browser/test_keeping.py browser/test_kits.py browser/test_learning.py browser/test_live_verdicts.py \
	browser/test_long_row.py browser/test_nearest.py browser/test_parts_tab.py \
	browser/test_pictures.py browser/test_recipes.py browser/test_recorded.py \
	browser/test_restoring.py browser/test_rows.py browser/test_scan_colours.py \
	browser/test_scene_script.py browser/test_stations.py browser/test_steps.py browser/test_tour.py \
	browser/test_watching.py browser/test_words.py cells/test_full_bin.py cells/test_table.py \
	cli/calibrating/test_calibrate.py cli/measuring cli/picking/test_hostile_plans.py \
	cli/picking/test_scan_units.py cli/serving/test_files_in_motion.py \
	devices/abb_egm/test_egm_rapid.py devices/pick_server/test_pick_cycles.py \
	devices/rapid/test_modules.py devices/rapid/test_wires.py \
	devices/universal_robots/test_ur_hostile.py examples extras/bop/test_searching.py \
	extras/evidence/test_forged_zips.py extras/opcua/test_opcua.py \
	extras/reconstruction/test_reconstruct.py foreign formats/meshes/test_convex_pieces.py \
	formats/parts/test_part_import.py gui/drawing/test_film.py gui/drawing/test_watching.py \
	gui/scene/test_measure.py packaging/test_bundle.py perception/calibration/test_opencv.py \
	perception/calibration/test_sureness.py perception/colours/test_telling.py \
	perception/localization/test_loosening.py perception/localization/test_real_scan.py \
	perception/scene/test_clearly_seen.py \
	perception/scene/test_seen_obstacles.py planning/grasps/test_firmness.py \
	planning/picking/test_properties.py planning/planners/test_planners.py plugins/test_pages.py \
	portable proof/claims/timing/test_point_speed.py \
	proof/claims/test_bent_kinds.py proof/test_good_plans.py proof/test_judge.py \
	robots/test_third_party.py studies test_new_part.py test_new_robot.py testing \
	web/api/test_fuzz.py web/http/test_crowds.py

# What `make test-fast` leaves out: browsers, whole commands, and what takes longest in its folder.
SLOW := browser cells cli examples packaging perception plugins portable proof studies testing \
	web test_new_part.py test_new_robot.py test_site.py test_skips.py app/core/test_any_sequence.py \
	app/emptying app/calibration/test_calibration.py app/calibration/test_first_scan.py \
	app/picking/test_part_import.py app/picking/test_row.py app/runtime/test_effect_runner.py \
	app/runtime/test_jobs.py app/runtime/test_killed.py app/runtime/test_link_faults.py \
	app/runtime/test_readiness.py extras devices/abb_egm devices/abb_socket/test_abb_program_link.py \
	devices/abb_socket/test_stepped.py devices/rapid \
	devices/scanners/test_merged.py formats/cells/test_cell_edits.py \
	formats/parts/test_part_import.py gui/cell/test_jog.py \
	gui/dragging/test_gizmo_drag.py gui/drawing/test_film.py gui/drawing/test_watching.py gui/grasps/test_grasp_controls.py \
	gui/page/test_renderer.py gui/scene/test_measure.py \
	gui/scene/test_scene.py planning/collision/test_motion.py planning/collision/test_tool_check.py \
	planning/grasps/test_part_rays.py planning/grasps/test_part_symmetry.py \
	planning/picking/test_dual_arm.py planning/picking/test_golden_plans.py \
	planning/picking/test_properties.py planning/planners/test_planners.py \
	robots/test_third_party.py

# Whole files to four workers, in the order of tests/conftest.py: what takes longest first.  Four
# for two cores, since many tests wait: for a plan that is played, a time that is over, a browser.
WORKERS := -n 4 --dist loadfile --no-loadscope-reorder

# More for the command behind a target: make run ARGS="--port 9000", make test ARGS="-k plan"
ARGS :=

export PYTHON

.PHONY: help run test test-all test-core test-fast test-portable foreign lint docs everything installed packages bench pictures words bundle constraints clean

help:
	@echo "make run       start the workbench on the simulated YuMi cell and print its link"
	@echo "make test      run the tests of the gate"
	@echo "make test-fast run those that take little, while you work"
	@echo "make test-core run those of the core, as where no extra is installed"
	@echo "make test-all  run all tests with coverage, then as if on another make of processor"
	@echo "make test-portable  run them as if on another make of processor"
	@echo "make foreign   bring what others publish through the documented commands (../shared/data/foreign)"
	@echo "make lint      check style, types, imports and the documents' prose"
	@echo "make docs      make the documents a site in build/site, without a network"
	@echo "make bench     measure what the README promises"
	@echo "make pictures  make the pictures of the documents anew"
	@echo "make words     bring the catalogs of languages up to date with what the page says"
	@echo "make bundle    make one file that installs the workbench without a network"
	@echo "make everything  install what lint, docs and test need, in one go"
	@echo "make clean     remove everything that make made"
	@echo "ARGS=... is handed on: make run ARGS='--port 9000', make test ARGS='-k proof'"

run: $(VENV)/.compiled
	@exec $(BIN)/workbench serve $(ARGS)

test: $(VENV)/.test $(VENV)/.compiled
	@bash setup/debian.sh $(BROWSER) $(STAND_INS)
	$(BIN)/python -m pytest $(WORKERS) $(if $(ARGS),,-m "not extensive" $(EXTENSIVE:%=--ignore=tests/%)) $(ARGS)

# Watching which lines run makes Python a third slower.
test-all:
	@$(MAKE) test ARGS="--cov $(ARGS)"
	@$(MAKE) test-portable

test-fast: $(VENV)/.test $(VENV)/.compiled
	$(BIN)/python -m pytest $(WORKERS) -m "not extensive" $(SLOW:%=--ignore=tests/%) $(ARGS)

# As where no extra is installed, nor a library that only extras need; whole commands are tried so
# in tests/plugins/test_extras.py.
test-core: $(VENV)/.test $(VENV)/.compiled
	PYTHONPATH=$(CURDIR)/tests/without_extras:$$PYTHONPATH $(BIN)/python -m pytest -m "not extensive" \
		--ignore=tests/app/core/test_any_sequence.py tests/app/core tests/journal tests/model $(ARGS)

foreign: $(VENV)/.test $(VENV)/.compiled
	$(BIN)/python tests/foreign/bring.py

# As if on another processor: what libraries can be told to leave out is left out.  Everything is
# compiled once more for it; browsers and processes that install something tell nothing new.
OTHER_PROCESSOR := OPENBLAS_CORETYPE=Haswell NPY_DISABLE_CPU_FEATURES=X86_V3 \
	GLIBC_TUNABLES=glibc.cpu.hwcaps=-AVX2,-FMA,-AVX,-FMA4 \
	NUMBA_CPU_NAME=generic NUMBA_CACHE_DIR=$(CURDIR)/build/numba-generic

test-portable: $(VENV)/.test
	env $(OTHER_PROCESSOR) $(BIN)/workbench compile
	env $(OTHER_PROCESSOR) $(BIN)/python -m pytest $(WORKERS) \
		--ignore tests/browser --ignore tests/packaging $(ARGS)

lint: $(VENV)/.lint $(VENV)/.test
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/pyright
	$(BIN)/lint-imports
	PYTHONPATH=$(CURDIR) $(BIN)/python setup/licences.py
	$(BIN)/python setup/prose.py

# Examples are run for it, so what is compiled has to be there.
docs: $(VENV)/.docs $(VENV)/.compiled
	$(BIN)/python docs/make_site.py

# What lint, docs and test need, found and installed in one go; each of them alone installs its own.
everything: installed
	@$(MAKE) $(VENV)/.compiled

installed: $(VENV)/.venv pyproject.toml constraints.txt
	@echo "Installing what is needed for the checks, the documents and the tests"
	@$(INSTALL) ".[test,lint,docs]"
	@touch $(VENV)/.run $(VENV)/.test $(VENV)/.lint $(VENV)/.docs

# What pip does not bring, beside what it does; behind what may need packages for Python itself.
packages: $(VENV)/.venv
	@bash setup/debian.sh $(LIBRARIES) $(BROWSER) $(STAND_INS)

bench: $(VENV)/.test $(VENV)/.compiled
	$(BIN)/workbench bench short $(ARGS)

# ARGS="grasps cell" makes only those; `docs/more_stories.py` has the names.
pictures: $(VENV)/.test $(VENV)/.compiled
	@bash setup/debian.sh $(BROWSER)
	PYTHONPATH=$(CURDIR)/tests/browser:$(CURDIR)/tests/devices:$(CURDIR)/tests $(BIN)/python docs/make_pictures.py $(ARGS)

# After a text of the page was changed: what is new stands in the catalogs, to be translated.
words: $(VENV)/.test
	$(BIN)/python -m workbench.words.extract

bundle: $(VENV)/.test $(VENV)/.compiled
	$(BIN)/python setup/bundle.py $(ARGS)

# After a dependency was changed and the tests pass with the newest versions.
constraints: $(VENV)/.lint $(VENV)/.test $(VENV)/.docs
	{ grep '^#' constraints.txt; $(BIN)/python -m pip freeze --exclude-editable; } > constraints.new
	mv constraints.new constraints.txt
	$(BIN)/uv pip compile --quiet --universal --python-version 3.11 --constraint constraints.txt --no-annotate \
		--generate-hashes --custom-compile-command "make constraints" pyproject.toml -o requirements.lock

clean:
	rm -rf $(VENV) build dist .pytest_cache .ruff_cache .hypothesis .import_linter_cache
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

# Stamps: what is installed is installed again only when one of these files has changed.
$(VENV)/.venv: setup/venv.sh
	@bash setup/venv.sh $(VENV) $(LIBRARIES)
	@touch $@

$(VENV)/.run: $(VENV)/.venv pyproject.toml constraints.txt
	@echo "Installing what the workbench needs; the first time this takes some minutes"
	@$(INSTALL) .
	@touch $@

# The inner loops, so that nobody waits for them at their first use.
$(VENV)/.compiled: $(VENV)/.run
	@bash setup/debian.sh $(LIBRARIES)
	@$(BIN)/workbench compile
	@touch $@

$(VENV)/.test: $(VENV)/.run
	@echo "Installing what the tests need"
	@$(INSTALL) ".[test]"
	@touch $@

$(VENV)/.lint: $(VENV)/.run
	@echo "Installing what the checks need"
	@$(INSTALL) ".[lint]"
	@touch $@

$(VENV)/.docs: $(VENV)/.run
	@echo "Installing what the site of the documents needs"
	@$(INSTALL) ".[docs]"
	@touch $@
