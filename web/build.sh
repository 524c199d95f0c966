#!/bin/sh
# Builds the page: build.sh SOURCE OUTPUT VERSION, with SOURCE the directory web of the sources and OUTPUT that of the build
# tree. Installs the libraries of package-lock.json under OUTPUT/npm when they are not there yet, and writes
# OUTPUT/dist: page.js and page.css from src/ in one file each, and what is served as it is.
set -eu
source=$(cd "$1" && pwd)
mkdir -p "$2/dist" "$2/npm"
output=$(cd "$2" && pwd)
version=$3

command -v npm >/dev/null 2>&1 || {
    echo "web: the page is built by npm; install nodejs and npm, or build from a release, which carries it" >&2
    exit 1
}
modules=$output/npm/node_modules
installed=$output/npm/installed.json
if ! cmp -s "$source/package-lock.json" "$installed"; then
    cp "$source/package.json" "$source/package-lock.json" "$source/.npmrc" "$output/npm/"
    (cd "$output/npm" && npm ci --silent --ignore-scripts --no-audit --no-fund)
    cp "$source/package-lock.json" "$installed"
fi

# the sources may lie elsewhere than node_modules: NODE_PATH is where esbuild looks last
NODE_PATH=$modules "$modules/.bin/esbuild" "$source/src/main.jsx" \
    --bundle --minify --format=esm --target=es2022 --charset=utf8 --legal-comments=none --log-level=warning \
    --jsx=automatic --jsx-import-source=preact --define:QUIETGEAR_VERSION="\"$version\"" \
    --outfile="$output/dist/page.js.new"
mv "$output/dist/page.js.new" "$output/dist/page.js"
NODE_PATH=$modules "$modules/.bin/esbuild" "$source/src/page.css" \
    --bundle --minify --charset=utf8 --log-level=warning --outfile="$output/dist/page.css"
cp "$source/index.html" "$source/icon.svg" "$output/dist/"
{
    echo "The page contains these libraries:"
    for package in preact d3-array d3-color d3-contour d3-format d3-interpolate d3-path d3-scale d3-shape d3-time \
        d3-time-format internmap; do
        printf '\n%s\n' "$package"
        cat "$modules/$package"/LICENSE*
    done
} >"$output/dist/licences.txt"
touch "$output/dist/page.js"
