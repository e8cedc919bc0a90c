# Every recipe uses the versions in Cargo.lock and nothing newer.
CARGO ?= cargo
FIGURES := fig04 fig06 fig07 fig08 fig10 fig11 fig12 locator

.PHONY: help figures report test golden readings cluster-test bench bench-peers check clean $(FIGURES)
.DEFAULT_GOAL := help

help: ## Show the targets
	@grep -E '^[a-z-]+:.*## ' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 13

figures: $(FIGURES) ## Compute and draw all figures into figures/

# One build for all binaries; the runs then only start them, one after the other even under make -j.
build-figures:
	$(CARGO) build --locked --release -p stickslip-replication --bins
.PHONY: build-figures
.NOTPARALLEL:

$(FIGURES): build-figures
	$(CARGO) run --locked --release --quiet -p stickslip-replication --bin $@ -- --out-dir figures

report: build-figures ## The verdict on every claim: report/index.html, report/claims.csv, figures/{convergence,scan}.*, README
	$(CARGO) run --locked --release --quiet -p stickslip-replication --bin report

test: ## Run all tests; the test profile is optimised, see Cargo.toml
	$(CARGO) test --locked

golden: ## Rewrite golden/ and what repeats it (figures/, report/, README) on purpose; look at the diff before committing it
	$(MAKE) figures report
	INSTA_UPDATE=always $(CARGO) test --locked

# A search that was stopped goes on where it was; one that is complete is never taken for a new one.
readings: build-figures ## Search all readings of Figs. 10-12 anew into golden/, some ten minutes
	$(CARGO) run --locked --release --quiet -p stickslip-replication --bin readings -- --out target/readings
	cp target/readings/readings.csv target/readings/readings.txt golden/
	rm -r target/readings

# The program as the tests build it: its bits are the same, and nothing is compiled twice.
cluster-test: ## A sweep as a job array on a Slurm of one node, with a kill and a requeue; needs slurm-wlm and munge
	$(CARGO) test --locked --no-run
	timeout --kill-after=10 150 cluster/test.sh "$$($(CARGO) metadata --locked --no-deps --format-version 1 | sed -E 's/.*"target_directory":"([^"]*)".*/\1/')/debug/stickslip"

bench: ## Run the benchmarks
	$(CARGO) bench --locked

# The peers get an environment of their own with the versions of requirements.txt. The stamp stands only after all of them
# are installed, so that a broken installation is tried again. PEERS_ARGS="--rounds 3" makes a short run.
PYTHON ?= python3
PEERS_ARGS ?=
PEERS_VENV := target/peers-venv
PEERS_STAMP := $(PEERS_VENV)/installed.txt
PEERS_WANTED := benches/peers/requirements.txt

bench-peers: ## Error against run time beside SciPy, numba, heyoka and pydiffsol; ours alone without Python
	$(CARGO) build --locked --release -p stickslip-replication --bin peers
	@if cmp -s $(PEERS_WANTED) $(PEERS_STAMP) \
	    || { $(PYTHON) -m venv --clear $(PEERS_VENV) \
	    && $(PEERS_VENV)/bin/python -m pip install --quiet --disable-pip-version-check -r $(PEERS_WANTED) \
	    && cp $(PEERS_WANTED) $(PEERS_STAMP); }; then \
	    $(CARGO) run --locked --release --quiet -p stickslip-replication --bin peers -- --python $(PEERS_VENV)/bin/python $(PEERS_ARGS); \
	else \
	    echo "no peers: Python 3.11 or later ($(PYTHON)) with venv, and a network to install $(PEERS_WANTED) from," \
	        "are needed; measuring ours alone" >&2; \
	    $(CARGO) run --locked --release --quiet -p stickslip-replication --bin peers -- $(PEERS_ARGS); \
	fi

check: ## Formatting, lints and documentation, every warning an error
	$(CARGO) fmt --all --check
	$(CARGO) clippy --locked --workspace --all-targets -- -D warnings
	$(CARGO) clippy --locked --workspace --all-targets --all-features -- -D warnings
	RUSTDOCFLAGS="-D warnings" $(CARGO) doc --locked --workspace --no-deps

clean: ## Remove what was built; figures/ and golden/ are part of the repository and stay
	$(CARGO) clean
