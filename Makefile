# make setup    the system packages, .venv and adc-bench itself; does nothing when they are there
# make demo     render, train, drive, score, rank: everything once, into demo/
# make test     the checks and the tests, a process a core         make proofs   the long ones
# make weights  train the weights that ship with the package       make bench   measure the README's figures
# make dataset  the public dataset: 11,000 frames and 60 drives, checked, counted and shown, into build/dataset
# make pictures draw the pictures of docs/arena.md and docs/labels.md
# make thesis   drive the thesis' experiments again, into build/thesis and docs/thesis.md
.PHONY: setup demo test check proofs weights dataset bench pictures thesis lock
BIN := .venv/bin

setup:
	@sh scripts/setup.sh

demo: setup
	@sh scripts/demo.sh demo

check: setup
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports

test: check
	@sh scripts/system_packages.sh browser
	@sh scripts/system_packages.sh compiler
	$(BIN)/pytest -n auto --maxprocesses 4 --dist loadfile --no-loadscope-reorder

proofs: setup
	$(BIN)/pytest -m slow

weights: setup
	@sh scripts/weights.sh

dataset: setup
	@sh scripts/dataset.sh

bench: setup
	@sh scripts/bench.sh

pictures: setup
	$(BIN)/python scripts/arena_pictures.py
	$(BIN)/python scripts/label_picture.py
	$(BIN)/python scripts/mask_picture.py

thesis: setup
	$(BIN)/adc-bench reproduce thesis --out build/thesis
	$(BIN)/python scripts/thesis_page.py build/thesis

lock:
	sh scripts/lock.sh --upgrade
