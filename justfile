# What a developer runs. `just` lists the recipes; each is one command that works without just too.

default:
    @just --list

# The README's test command.
test:
    cargo test --workspace

# Exactly what the gate runs.
ci:
    bash .ci/run

# Long random tests, with another seed each time; proptest prints and keeps the seed of a failure. `just torture 100000`
# for more. The round trips of the kinematics, the choice of branches and the programs from dialect to dialect print their seed;
# TRUNNION_TORTURE_SEED=... repeats one.
torture cases="20000" seed=`date +%s`:
    TRUNNION_TORTURE=1 cargo test --release -p trunnion-motion -p trunnion --test it -- --nocapture branches:: setup:: feed:: jerk:: jerk_ends:: feed_stream:: jerk_stream:: jerk_override:: round_trip:: random_motion:: random_programs:: planted_bodies::
    TRUNNION_TORTURE=1 TRUNNION_TORTURE_SEED={{seed}} cargo test --release -p trunnion-rt --test it -- --nocapture operation::
    TRUNNION_TORTURE=1 TRUNNION_TORTURE_SEED={{seed}} cargo test --release -p trunnion-cli --test it -- --nocapture conservation:: rs274:: linuxcnc_planner::
    PROPTEST_RNG_SEED={{seed}} PROPTEST_CASES={{cases}} POSITIONING_CASES=1000 cargo test --release --workspace

# Every fuzz target for so many seconds. Needs a nightly compiler and cargo-fuzz; failures stay in fuzz/artifacts.
fuzz seconds="60":
    #!/usr/bin/env bash
    set -euo pipefail
    for target in $(cargo +nightly fuzz list); do
        mkdir -p "fuzz/corpus/$target"
        cargo +nightly fuzz run "$target" -- -max_total_time={{seconds}} -timeout=10 -rss_limit_mb=2048
    done

# The Python package: wheel, fresh environment, tests, notebooks.
python:
    bash .ci/python

# The FreeCAD add-on in FreeCAD 1.x (suite trixie: 1.0, forky: 1.1). Needs Debian, root, debootstrap, and the Python package installed in `site`.
freecad-1 site suite="trixie":
    bash .ci/freecad-1 {{site}} {{suite}}

# Figures, side by side with their peers.
bench:
    cargo bench --workspace

# Figures of machines: errors found by calibration, a part made anew, distances of bodies over long programs.
machine-figures:
    cargo run --release -p trunnion-motion --example calibration_figures
    cargo run --release -p trunnion --example body_distances

# The book, to target/book. Needs mdbook.
book:
    mdbook build docs/book

# Pictures of README and book: the drawings, and a real run. Needs Python, Chromium and ImageMagick.
pictures:
    python3 docs/book/draw.py
    bash docs/pictures.sh

# Accept the help texts, tables and pages as they are now; read the difference line by line.
snapshots:
    UPDATE_EXPECT=1 cargo test -p trunnion-cli

# Plain parts of another CAD kernel, proposed and run: a table of outcomes and times. Needs Python with build123d.
corpus folder="target/corpus":
    cargo build --release -p trunnion-cli
    python3 fixtures/corpus/generate.py {{folder}}/parts
    python3 fixtures/corpus/run.py target/release/trunnion {{folder}}/parts --out {{folder}}/out

# Programs of another CAM system, checked against their parts: a table of answers and times. Needs FreeCAD.
cam-programs folder="target/cam-programs":
    cargo build --release -p trunnion-cli
    PARTS=fixtures/corpus/gate FOLDER={{folder}} freecadcmd fixtures/cam-programs/generate.py
    python3 fixtures/cam-programs/run.py target/release/trunnion {{folder}}

# Rewrite the fixtures from their generators (needs Python; the STEP ones also build123d).
fixtures:
    python3 fixtures/bezier-patch/make.py
    python3 fixtures/step/generate.py

# The studio: its engine, the site in studio/dist, and a `trunnion` that has it inside (needs Node).
studio:
    cd studio && npm ci && node engine.mjs && npm run build
    cargo build --release -p trunnion-cli --features studio

# Rebuild the page that the report embeds (needs Node).
viewer:
    cd viewer && npm ci && npm run build
