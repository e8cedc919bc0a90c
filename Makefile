# Every recipe uses the versions in Cargo.lock and nothing newer.
CARGO ?= cargo
FIGURES := fig04 fig06 fig07 fig08 fig10 fig11 fig12 locator

.PHONY: help figures report test golden readings captions fit-coverage shooting random mutants fuzz old-processor archive second-opinion diagrams cluster-test bench bench-peers bench-pages wheel python-test docs paper dist release-check format check clean $(FIGURES)
.DEFAULT_GOAL := help

help: ## Show the targets
	@grep -E '^[a-z-]+:.*## ' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 16

figures: $(FIGURES) ## Compute and draw all figures into figures/

# One build for all figures, by the profile of the tests. With PROGRAM_IS_BUILT set, the tests built
# them. They start one after the other even under make -j.
REPLICATION := --locked --quiet -p stickslip-replication
build-figures:
	test -n "$$PROGRAM_IS_BUILT" || $(CARGO) build --locked -p stickslip-replication --bins
build-replication:
	$(CARGO) build --locked -p stickslip-replication --bins --release
.PHONY: build-figures build-replication
.NOTPARALLEL:

$(FIGURES): build-figures
	$(PROGRAMS)/$@ --out-dir figures

report: build-replication ## The verdict on every claim: report/index.html, report/claims.csv, README's verdicts, provenance
	$(CARGO) run $(REPLICATION) --release --bin report
	archive/provenance.sh > target/provenance.json && mv target/provenance.json report/

# The extension module of Python has no tests in Rust and is not compiled. Selecting it gives shared
# crates the features of the wheel, so that both take one build. `cargo test` alone is the check of
# the replication.
TESTED := --locked --workspace

test: ## Run all tests; the test profile is optimised, see Cargo.toml
	$(CARGO) test $(TESTED)

golden: ## Rewrite golden/, figures/, report/, README's verdicts on purpose; not what takes a search or peers
	$(MAKE) figures report diagrams
	INSTA_UPDATE=always $(CARGO) test $(TESTED)

readings: build-replication ## Search all readings of Figs. 10-12 anew into golden/, some ten minutes
	$(CARGO) run $(REPLICATION) --release --bin readings -- --out golden

captions: build-replication ## Captions of Figs. 10-12 moved within their rounding: golden/captions.csv, some ten minutes
	$(CARGO) run $(REPLICATION) --release --bin captions -- --out-dir golden

fit-coverage: ## How often intervals of fits contain the truth: crates/stickslip-model/examples/fit_coverage
	$(CARGO) run --locked --release -p stickslip-model --example fit_coverage -- crates/stickslip-model/examples/fit_coverage

shooting: ## 100 chaotic records by multiple and by single shooting; some minutes; 90 are missed
	$(CARGO) test --locked --release -p stickslip-model --test suite -- --ignored --nocapture 90_of_100_chaotic

# Chains of friction, both methods and runs in pieces pass. Of 10,000 chains of stops, 8 end wrong
# (see docs/explanation/events.md, "Jumps"), and 79 differ by method: 77 of these by an impact
# within 1e-6 of a landing.
random: ## 10,000 random systems: both methods, in pieces, stops (not all pass), friction; an hour
	$(CARGO) test $(TESTED) --test suite --test contacts -- --ignored --nocapture --test-threads 1 ten_thousand_random

mutants: ## Change constants, digits and signs one at a time; the tests must notice each; an hour
	tests/mutants.sh

# The parts of the input that a user writes, each with a target in fuzz/. FUZZ_SECONDS=900 is an hour.
FUZZED := system_file formula number_table sweep_block
FUZZ_SECONDS ?= 300
fuzz: ## Broken input to system files, formulas, tables, blocks; needs cargo-fuzz
	fuzz/run.sh $(FUZZ_SECONDS) $(FUZZED)

old-processor: build-figures ## The same bits without AVX and FMA, by an emulator (qemu-user); ten minutes
	$(CARGO) build --locked -p stickslip-cli
	tests/old_processor.sh $(PROGRAMS) $(FIGURES)

archive: ## Sources, crates, figures, golden files and page in dist/, to be built without a network
	CARGO=$(CARGO) archive/make.sh

second-opinion: ## The main numbers once more in plain Python, compared with golden/; a quarter of a minute
	$(PYTHON) second-opinion/second_opinion.py golden

# The folder that cargo builds into.
TARGET = "$$($(CARGO) metadata --locked --no-deps --format-version 1 | sed -E 's/.*"target_directory":"([^"]*)".*/\1/')"
PROGRAMS = $(TARGET)/debug
STICKSLIP = $(PROGRAMS)/stickslip

# The JSON output of a command is its golden. A sweep resumes from its blocks, so these are removed
# first. The commands run in the folder of their output, so that no golden names a build folder.
DIAGRAMS := target/diagrams
DIAGRAM = cd $(DIAGRAMS) && $(STICKSLIP)

SPEEDS := 1.1 1.175 1.25 1.4 1.475 1.55 1.7 1.775 1.85

diagrams: ## Figures of the program stickslip with their goldens, some minutes
	$(CARGO) test $(TESTED) --no-run
	rm -rf $(DIAGRAMS) && mkdir -p $(DIAGRAMS)
	$(DIAGRAM) basin forced --grid 100x100 --out basin --json > basin.json
	$(DIAGRAM) basin basins --grid 200x200 --out basins --json > basins.json
	cd $(DIAGRAMS) && { separator='['; for vd in $(SPEEDS); do \
	    echo "$$separator"; separator=','; \
	    $(STICKSLIP) basin basins --set vd=$$vd --grid 100x100 --until 20000 --tol 1e-8 --out basins-$$vd --json || exit 1; \
	done; echo ']'; } > shares.json
	$(DIAGRAM) bifurcation forced --parameter mu0=0.1262:0.1325 --start x=-0.269 --start v=-1.52 --values 127 --duration 200 --out bifurcation --json > bifurcation.json
	$(DIAGRAM) continue forced --set mu0=0.1303 --start x=-0.269 --start v=-1.52 --periods 2 --parameter mu0=0.02:0.195 --step 0.002 --out branch --json > branch.json
	$(DIAGRAM) map forced --x mu0=0.122:0.134 --y omega=3.76:3.86 --start x=-0.269 --start v=-1.52 --grid 48x36 --until 400 --duration 60 --out map --json > map.json
	cp $(DIAGRAMS)/basin/basin.svg $(DIAGRAMS)/bifurcation/bifurcation.svg $(DIAGRAMS)/map/map.svg figures/
	cp $(DIAGRAMS)/basins/basin.svg figures/basins.svg
	cp $(DIAGRAMS)/branch/continue.svg figures/branch.svg
	cp $(DIAGRAMS)/*.json golden/

# The program as the tests build it: its bits are the same, and nothing is compiled twice.
cluster-test: ## A sweep as a job array on a Slurm of one node; needs slurm-wlm and munge
	$(CARGO) test $(TESTED) --no-run
	timeout --kill-after=10 150 cluster/test.sh $(STICKSLIP)

bench: ## Run the benchmarks
	$(CARGO) bench $(TESTED) --benches

# The peers and the wheel get an environment of their own. The stamp is written after all of them are
# installed, so that a broken installation is tried again. BENCHES="orbits" makes one table only,
# BENCH_ARGS="--rounds 1 decay" a short run.
PYTHON ?= python3
BENCHES ?= orbits python basins spectra
BENCH_ARGS ?=
BENCH_VENV := target/bench-venv
BENCH_WANTED := benches/requirements.txt
RELEASE = $(TARGET)/release
BENCH_orbits = $(RELEASE)/examples/bench
BENCH_basins = $(RELEASE)/stickslip $(RELEASE)/examples/basin
BENCH_spectra = $(RELEASE)/stickslip

bench-peers: wheel ## Error, time and lines beside other tools: the tables of report/, docs/speed.md
	cmp -s $(BENCH_WANTED) $(BENCH_VENV)/installed.txt || { $(PYTHON) -m venv --clear $(BENCH_VENV) \
	    && $(BENCH_VENV)/bin/python -m pip install --quiet --disable-pip-version-check -r $(BENCH_WANTED) \
	    && cp $(BENCH_WANTED) $(BENCH_VENV)/installed.txt; }
	$(BENCH_VENV)/bin/python -m pip install --quiet --disable-pip-version-check --no-deps --force-reinstall dist/*.whl
	$(CARGO) build --locked --release -p stickslip-cli
	$(CARGO) build --locked --release -p stickslip --example basin
	$(CARGO) build --locked --release -p stickslip-replication --example bench
	$(foreach bench,$(BENCHES),$(BENCH_VENV)/bin/python benches/bench.py $(bench) $(BENCH_$(bench)) $(BENCH_ARGS) &&) true
	$(MAKE) bench-pages

bench-pages: ## figures/bench.svg, docs/speed.md, sentences of README and article from the tables
	$(CARGO) run --locked --quiet --release -p stickslip-replication --example bench -- draw report/bench.csv figures
	$(PYTHON) benches/bench.py pages

# WHEEL_PROFILE=dev compiles faster; tests use it. Both need Python 3.11 or later and, the first time,
# a network.
wheel: ## The Python package: dist/*.whl
	PYTHON=$(PYTHON) CARGO=$(CARGO) python/make.sh wheel $(WHEEL_PROFILE)

python-test: ## Install the wheel into an empty environment and run its tests; exit code 75: no network
	PYTHON=$(PYTHON) CARGO=$(CARGO) python/make.sh test $(WHEEL_PROFILE)

# Code blocks run on the wheel and the program, and write the pictures of the pages. The documentation
# of the crates and the report are copied beside the pages. Of the crates only the libraries are
# documented, since the program has the name of one. Examples run each time, since what they use may
# have changed. The report's links to files of the project are dropped: the site has no sources.
DOCS_VENV := target/docs-venv
DOCS := target/docs/html

docs: wheel ## The site: target/docs/html/index.html, every code block run; needs Python 3.11 or later
	if test -n "$$PROGRAM_IS_BUILT"; then test -x $(STICKSLIP); else $(CARGO) build --locked -p stickslip-cli; fi
	test -x $(DOCS_VENV)/bin/python || $(PYTHON) -m venv $(DOCS_VENV)
	$(DOCS_VENV)/bin/python -m pip install --quiet --disable-pip-version-check -r docs/requirements.txt
	$(DOCS_VENV)/bin/python -m pip install --quiet --disable-pip-version-check --force-reinstall --no-deps dist/*.whl
	STICKSLIP=$(STICKSLIP) $(DOCS_VENV)/bin/python -m pytest -q -p no:cacheprovider docs benches archive
	rm -rf $(DOCS) docs/_gallery docs/reference/_api
	STICKSLIP=$(STICKSLIP) $(DOCS_VENV)/bin/python -m sphinx -W --keep-going -q -d target/docs/doctrees docs $(DOCS)
	rm -rf $(TARGET)/doc
	RUSTDOCFLAGS="-D warnings" $(CARGO) doc --locked --workspace --no-deps --lib
	cp -r $(TARGET)/doc $(DOCS)/rust
	mkdir $(DOCS)/report && sed -E 's/ href="\.\.\/[^"]*"//g' report/index.html > $(DOCS)/report/index.html
	$(DOCS_VENV)/bin/python docs/check_links.py $(DOCS)

# The article. Its engine makes the PDF from LaTeX, or from HTML where there is no LaTeX.
PDF_ENGINES := xelatex lualatex tectonic weasyprint
paper: ## The article joss/paper.md: target/paper.pdf; needs pandoc and one of xelatex, weasyprint
	@command -v pandoc >/dev/null || { echo "not built: pandoc is missing; install it" >&2; exit 75; }
	@for engine in $(PDF_ENGINES); do command -v $$engine >/dev/null || continue; mkdir -p target; \
	    cd joss && exec pandoc --citeproc --metadata author="stickslip maintainers" \
	        --pdf-engine=$$engine paper.md -o ../target/paper.pdf; done; \
	    echo "not built: no engine is there; install one of $(PDF_ENGINES)" >&2; exit 75

# What a release consists of: the library's packages, the wheel and its source, and the program for
# this machine.
VERSION := $(shell sed -n '/workspace.package/,/^$$/s/^version = "\(.*\)"/\1/p' Cargo.toml)
PROGRAM_NAME := stickslip-$(VERSION)-$(shell uname -m)-$(shell uname -s | tr A-Z a-z)

dist: ## What a release consists of, in dist/: crates, wheel, program; needs Python and a network
	PYTHON=$(PYTHON) CARGO=$(CARGO) python/make.sh release
	$(CARGO) package --locked -p stickslip-numerics -p stickslip
	cp $(TARGET)/package/stickslip*-$(VERSION).crate dist/
	$(CARGO) build --locked --release -p stickslip-cli
	rm -rf target/dist && mkdir -p target/dist/$(PROGRAM_NAME)
	cp $(RELEASE)/stickslip LICENSE README.md CHANGELOG.md target/dist/$(PROGRAM_NAME)
	tar -C target/dist -czf dist/$(PROGRAM_NAME).tar.gz $(PROGRAM_NAME)
	cd dist && sha256sum *.whl *.crate *.tar.gz > SHA256SUMS && cat SHA256SUMS

release-check: ## What is left before a release: versions, licences, public names, empty fields
	$(CARGO) check --manifest-path fuzz/Cargo.toml --target-dir target/fuzz-check
	$(PYTHON) archive/release.py check

format: ## Formatting and lines, in seconds; the first part of `make check`
	@! git ls-files '*.rs' '*.md' | LC_ALL=C.UTF-8 xargs grep -nE '^[^|].{100}' \
	    || { echo "the lines above are longer than 100 columns" >&2; exit 1; }
	$(CARGO) fmt --all --check

check: format ## Formatting, lines, lints and documentation, every warning an error
	$(CARGO) clippy --locked --workspace --all-targets --all-features -- -D warnings
	$(CARGO) test --locked --quiet -p output --features png
	RUSTDOCFLAGS="-D warnings" $(CARGO) doc --locked --workspace --no-deps

clean: ## Remove what was built; figures/ and golden/ are part of the repository and stay
	$(CARGO) clean
