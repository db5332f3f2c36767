# arcref: the front door. `make` does the main job, `make help` lists the rest.

PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
BUILD  := build
RUN    := examples/polygon_before_correction.csv
PUBLISHED_ROM := $(BUILD)/arcref.rom.json
ROM    ?= $(PUBLISHED_ROM)
CORE   := $(BUILD)/core.v
SPEED  ?= 10
TURNS  ?= 10
SAMPLES ?= 4
BOARD  ?= ulx3s
BOARDS := ulx3s hx8k icebreaker
READY  := $(VENV)/.ready
HOST_SOURCES     := $(wildcard host/arcref/*.py host/arcref/calibration/*.py host/arcref/calibration/fits/*.py)
GATEWARE_SOURCES := $(wildcard gateware/arcref_gateware/*.py gateware/arcref_gateware/boards/*.py)

.DEFAULT_GOAL := zero-return
.DELETE_ON_ERROR:
.PHONY: help rom calibrate subdivision zero-return verilog bitstream patch flash test test-boards bench lint clean manual pins

help: ## list the targets
	@grep -hE '^[a-z-]+:.*## ' $(MAKEFILE_LIST) | sed -E 's/^([a-z-]+):.*## /  make \1\t/' | expand -t 20

rom: $(PUBLISHED_ROM) ## fit the published polygon run and write the correction ROM image

calibrate: | $(READY) ## simulate a polygon run, calibrate from it with a report, and write its ROM
	@mkdir -p $(BUILD)
	@$(BIN)/arcref simulate polygon --seed 5 --rounds 2 --backward --tilt 300 --tilt-azimuth 60 -o $(BUILD)/polygon_run.csv
	@$(BIN)/arcref calibrate polygon $(BUILD)/polygon_run.csv -o $(BUILD)/polygon.cal.json --report $(BUILD)/polygon.html
	@$(BIN)/arcref rom $(BUILD)/polygon.cal.json -o $(BUILD)/polygon.rom.json

SUBDIVISION := $(BUILD)/subdivision

subdivision: | $(READY) ## calibrate a simulated encoder within the line, too, and show what one and both tables leave
	@mkdir -p $(SUBDIVISION)
	@$(BIN)/arcref simulate subdivision --run polygon --seed 4 -o $(SUBDIVISION)/turn.csv
	@$(BIN)/arcref simulate subdivision --run edges --seed 4 -o $(SUBDIVISION)/edges.csv
	@$(BIN)/arcref calibrate polygon $(SUBDIVISION)/turn.csv -o $(SUBDIVISION)/turn.cal.json
	@$(BIN)/arcref calibrate subdivision $(SUBDIVISION)/edges.csv -o $(SUBDIVISION)/edges.cal.json --report $(SUBDIVISION)/edges.html
	@$(BIN)/arcref rom $(SUBDIVISION)/turn.cal.json -o $(SUBDIVISION)/first.rom.json
	@$(BIN)/arcref rom $(SUBDIVISION)/turn.cal.json --subdivision $(SUBDIVISION)/edges.cal.json -o $(SUBDIVISION)/both.rom.json
	@$(BIN)/arcref simulate corrected --seed 4 --rom $(SUBDIVISION)/first.rom.json --rom $(SUBDIVISION)/both.rom.json \
	    --plot $(SUBDIVISION)/corrected.svg

zero-return: $(ROM) ## run the simulated zero-return test (SPEED=10 TURNS=10 SAMPLES=4); also what `make` does
	@$(BIN)/arcref simulate zero-return --speed $(SPEED) --revolutions $(TURNS) --samples $(SAMPLES) --rom $(ROM) \
	    --curve $(RUN) --page $(BUILD)/zero_return.html --json $(BUILD)/zero_return.json

verilog: $(CORE) ## write the core as Verilog, with the ROM inside

bitstream: $(ROM) | $(READY) ## place and route the bitstream of a board (BOARD=ulx3s ROM=your.rom.json)
	@$(BIN)/arcref build --board $(BOARD) --rom $(ROM)

patch: $(ROM) | $(READY) ## put another ROM into it, in seconds (BOARD=ulx3s ROM=your.rom.json)
	@$(BIN)/arcref patch --board $(BOARD) --rom $(ROM)

flash: $(ROM) | $(READY) ## write it into the board and verify it (BOARD=ulx3s ROM=your.rom.json)
	@$(BIN)/arcref flash --board $(BOARD) --rom $(ROM)

test: $(READY) ## run the tests; one board is placed and routed among them
	@$(BIN)/python -m pytest -m "not long"

test-boards: $(READY) ## place and route every board, and hold its timing and its tables to what they must be
	@$(BIN)/python -m pytest -m long

bench: $(ROM) ## build the three boards and print what they reach; turn ten times at every word size; compare speeds
	@for board in $(BOARDS); do $(MAKE) --no-print-directory $(BUILD)/$$board/build.json || true; done
	@$(BIN)/python tests/bench/board_table.py $(BUILD) $(BOARDS)
	@for samples in 1 2 4; do $(BIN)/arcref simulate zero-return --samples $$samples --rom $(ROM) --curve $(RUN) || exit; done
	@$(BIN)/arcref simulate zero-return --speed 63.48 --samples 4 --rom $(ROM) --curve $(RUN)
	@$(BIN)/python tests/bench/compare_speed.py

lint: $(READY) ## check the style of every Python file
	@$(BIN)/ruff check .

clean: ## remove what was built, but keep the installed tools
	rm -rf $(BUILD) .pytest_cache .ruff_cache .hypothesis

manual: $(READY) ## write tables, outputs and pictures of README.md and docs/ anew from what the project does
	@$(BIN)/python -m arcref_gateware.manual_tables README.md docs/core.md docs/calibration.md docs/instrument.md
	@$(BIN)/python -m arcref_gateware.boards.board_pages docs/boards
	@test ! -f $(BUILD)/ulx3s/build.json || $(BIN)/python -m arcref_gateware.boards.readme_build $(BUILD)/ulx3s/build.json README.md
	@$(BIN)/python -m arcref_sim.readme_calibration README.md

pins: ## pin every package again, with hashes, from pyproject.toml (needs pip-compile)
	pip-compile -q --generate-hashes --strip-extras --allow-unsafe --no-emit-index-url --no-emit-find-links \
	    -o requirements/host.txt pyproject.toml
	pip-compile -q --generate-hashes --strip-extras --allow-unsafe --no-emit-index-url --no-emit-find-links \
	    --extra gateware --extra sim --extra boards --extra test -o requirements/all.txt pyproject.toml

$(READY): pyproject.toml requirements/all.txt
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	    { echo "arcref needs Python 3.11 or newer; name one with: make PYTHON=/path/to/python3.11"; exit 2; }
	@command -v c++ >/dev/null && command -v perl >/dev/null || \
	    { echo "arcref needs a C++ compiler and perl; install them, then run make again"; exit 2; }
	@echo "setting up $(VENV): about a minute, once"
	@$(PYTHON) -m venv $(VENV)
	@$(BIN)/python -m pip install -q --disable-pip-version-check --require-hashes -r requirements/all.txt
	@$(BIN)/python -m pip install -q --disable-pip-version-check --no-deps --no-build-isolation -e .
	@touch $@

$(PUBLISHED_ROM): $(RUN) $(HOST_SOURCES) | $(READY)
	@mkdir -p $(BUILD)
	@$(BIN)/arcref rom $(RUN) -o $@ --plot $(BUILD)/arcref.rom.svg

$(BUILD)/%/build.json: constraints/%.toml $(ROM) $(GATEWARE_SOURCES) | $(READY)
	@$(BIN)/arcref build --board $* --rom $(ROM)

$(CORE): $(ROM) $(GATEWARE_SOURCES) | $(READY)
	@$(BIN)/arcref verilog --samples $(SAMPLES) --rom $(ROM) -o $@
