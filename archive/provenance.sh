#!/bin/sh
# Prints what the committed results were made from, as JSON. The file is not committed: it names the
# commit, which no file of that commit can hold.
set -eu
cd "$(dirname "$0")/.."

version=$(sed -n '/workspace.package/,/^$/s/^version = "\(.*\)"/\1/p' Cargo.toml)
commit=null
changed=null
if git rev-parse --verify -q HEAD >/dev/null 2>&1; then
    commit="\"$(git rev-parse HEAD)\""
    # Besides what the release is made of, a changed file makes the commit's name wrong.
    if [ -z "$(git status --porcelain)" ]; then changed=false; else changed=true; fi
fi

hashes() {
    find "$@" -type f ! -name provenance.json | LC_ALL=C sort | xargs sha256sum |
        sed 's/^\([0-9a-f]*\) [ *]\(.*\)$/    "\2": "\1",/' | sed '$s/,$//'
}

cat <<JSON
{
  "name": "stickslip-replication",
  "version": "$version",
  "commit": $commit,
  "differs_from_commit": $changed,
  "compiler": "$(${RUSTC:-rustc} --version)",
  "sha256": {
    "Cargo.lock": "$(sha256sum Cargo.lock | cut -d ' ' -f 1)",
$(hashes data figures golden report)
  }
}
JSON
