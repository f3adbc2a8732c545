# Short names for what is done often; CMake and its presets do the work. `make` lists them.
SHELL := /bin/bash
.SHELLFLAGS := -euo pipefail -c
.DEFAULT_GOAL := help
MAKEFLAGS += --no-print-directory

JOBS ?= $(shell nproc)
SOURCES = git ls-files -z -- '*.cpp' '*.h'

# Configured every time, because the program states the commit it was built from.
.PHONY: configure
configure:
	cmake --preset release

.PHONY: deps
deps: ## install the Debian packages that are not there yet
	@missing=$$(comm -23 <(sed -E 's/#.*//; s/[[:space:]]+//g; /^$$/d' dependencies.apt | sort -u) \
	  <(dpkg-query -W -f '$${db:Status-Status} $${Package}\n' | sed -n 's/^installed //p' | sort -u)); \
	if [ -n "$$missing" ]; then \
	  sudo=; [ "$$(id -u)" -eq 0 ] || sudo=sudo; \
	  $$sudo apt-get update </dev/null; \
	  $$sudo env DEBIAN_FRONTEND=noninteractive apt-get install -y $$missing </dev/null; \
	fi

.PHONY: build
build: deps configure ## build/release/backsight and all tests
	cmake --build --preset release -j $(JOBS)

.PHONY: demo
demo: build ## simulate a small campaign, register it and say where the report is
	build/release/backsight demo demo

.PHONY: test
test: build ## build and run all tests
	ctest --preset release -j $(JOBS)

.PHONY: campaigns
campaigns: build ## all simulated campaigns against their truth, small and big; takes long
	ctest --preset campaigns

.PHONY: bench
bench: build ## run the benchmarks
	@if [ -x tests/benchmarks/run ]; then exec tests/benchmarks/run; fi; \
	found=; \
	for program in build/release/tests/benchmarks/*_benchmark; do \
	  [ -x "$$program" ] || continue; found=yes; echo "== $$program"; "$$program"; \
	done; \
	[ -n "$$found" ] || { echo 'No benchmarks were built.' >&2; exit 1; }

.PHONY: format
format: ## format all sources
	@$(SOURCES) | xargs -0 -r clang-format -i

.PHONY: check-format
check-format: ## fail where a source is not formatted
	@$(SOURCES) | xargs -0 -r clang-format --dry-run -Werror

.PHONY: lint
lint: configure ## source rules, shellcheck and clang-tidy
	python3 tests/lint/source_rules.py
	shellcheck .ci/run docs/nightly/mail_summary
	JOBS=$(JOBS) tests/lint/clang_tidy.py build/release

.PHONY: sanitize
sanitize: deps ## all tests under address and undefined behaviour sanitizers
	cmake --preset asan-ubsan
	cmake --build --preset asan-ubsan -j $(JOBS)
	ctest --preset asan-ubsan -j $(JOBS)

.PHONY: options-doc
options-doc: build ## write docs/options.md from the program's own table
	build/release/backsight options --markdown > build/options.md
	mv build/options.md docs/options.md

.PHONY: clean
clean: ## remove build/ and demo/
	rm -rf build demo

.PHONY: help
help: ## this list
	@sed -nE 's/^([a-z-]+):[^#]*## (.*)/\1\t\2/p' Makefile | while IFS=$$'\t' read -r name what; do \
	  printf '  make %-13s %s\n' "$$name" "$$what"; done
