# What a developer runs. `just` lists the recipes; each is one command that works without just too.

default:
    @just --list

# The README's test command.
test:
    cargo test --workspace

# Exactly what the gate runs.
ci:
    bash .ci/run

# Long random tests; prints its seed. `just torture 100000` for more cases.
torture cases="20000":
    PROPTEST_CASES={{cases}} cargo test --release --workspace

# Figures, side by side with their peers.
bench:
    cargo bench --workspace

# Rewrite the fixtures from their generators (needs Python; the STEP ones also build123d).
fixtures:
    python3 fixtures/bezier-patch/generate.py
    python3 fixtures/step/generate.py

# Rebuild the page that the report embeds (needs Node).
viewer:
    cd viewer && npm ci && npm run build
