#!/bin/sh
# Packs all that the results need into dist/: sources, crates, figures, golden files, page, and the
# files that say what they are. The archive builds without a network.
set -eu
cd "$(dirname "$0")/.."
command -v git >/dev/null && git rev-parse -q --verify HEAD >/dev/null ||
    { echo "make archive needs a clone of the repository" >&2; exit 1; }

version=$(sed -n '/workspace.package/,/^$/s/^version = "\(.*\)"/\1/p' Cargo.toml)
date=$(git log -1 --format=%cs)
name=stickslip-replication-$version
folder=target/archive/$name
rm -rf "$folder" target/archive/home
mkdir -p "$folder/.cargo" dist
git ls-files -z | tar --null -T - -cf - | tar -xf - -C "$folder"
archive/provenance.sh > "$folder/report/provenance.json"
sed -e "s/@VERSION@/$version/" -e "s/@DATE@/$date/" archive/ro-crate-metadata.json \
    > "$folder/ro-crate-metadata.json"
(
    cd "$folder"
    # With --quiet, cargo does not print the configuration that leads to the crates.
    ${CARGO:-cargo} vendor --locked vendor > .cargo/config.toml
    # All crates must be found without a network and without the crates of this machine.
    CARGO_HOME="$PWD/../home" ${CARGO:-cargo} metadata --locked --offline --format-version 1 \
        > /dev/null
    find . -type f ! -name SHA256SUMS -print0 | LC_ALL=C sort -z | xargs -0 sha256sum > SHA256SUMS
    sha256sum --check --quiet SHA256SUMS
)
tar -C target/archive --sort=name --owner=0 --group=0 --mtime="$date" \
    -czf "dist/.$name.tar.gz" "$name"
mv "dist/.$name.tar.gz" "dist/$name.tar.gz"
sha256sum "dist/$name.tar.gz"
