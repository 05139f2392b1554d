#!/usr/bin/env bash
# Makes the pictures of README and book from a real run of the example job.
# Needs Rust, Chromium, ImageMagick and pngquant (Debian: chromium, imagemagick, pngquant).
set -euo pipefail
cd "$(dirname "$0")/.."
images=docs/book/src/images
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

cargo run --release --quiet -- run examples/bezier-patch/job.toml -o "$scratch/out" > /dev/null
chromium --headless --no-sandbox --no-first-run --disable-background-networking --disable-component-update \
    --disable-sync --use-gl=angle --use-angle=swiftshader --enable-unsafe-swiftshader --user-data-dir="$scratch/profile" \
    --window-size=1400,2100 --virtual-time-budget=8000 --screenshot="$scratch/page.png" \
    "file://$scratch/out/report.html" 2> /dev/null

# The head of the page with part, passes, deviation and tool; then the axes against their limits.
convert "$scratch/page.png" -crop 1330x1090+35+10 +repage -resize 60% -colors 128 "$images/report.png"
convert "$scratch/page.png" -crop 1330x640+35+1115 +repage -resize 60% -colors 64 "$images/motion.png"

# The studio, as its own test leaves it: `just studio`, then `npm run check` in studio/.
for name in place faces; do
    pngquant --quality 60-95 128 "studio/test/pictures/$name.png" --output "$scratch/$name.png"
done
cp "$scratch/place.png" "$images/studio.png"
cp "$scratch/faces.png" "$images/studio-faces.png"
ls -l "$images"
