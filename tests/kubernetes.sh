#!/usr/bin/env bash
# The manifests of docs/examples/kubernetes: valid under Kubernetes' own schema, and their commands, run here index by index on
# four small maps, make what one run makes, byte for byte.
#
#     tests/kubernetes.sh                  # builds the runner; XTASK=path/to/xtask takes one that is built
#
# Needs Python 3 with venv: installs kubernetes-validate, which carries the schemas of all versions, into a folder that vanishes.
set -euo pipefail
repository=$(cd "$(dirname "$0")/.." && pwd)
manifests=$repository/docs/examples/kubernetes

if [ -z "${XTASK:-}" ]; then
    (cd "$repository" && cargo build --release --package xtask)
    XTASK=${CARGO_TARGET_DIR:-$repository/target}/release/xtask
fi
root=$(mktemp -d /tmp/kubernetes-test.XXXXXX)
trap 'rm -rf "$root"' EXIT
python3 -m venv "$root/venv"
"$root/venv/bin/pip" install --quiet kubernetes-validate

# Indexed retries are there since 1.29.
for version in 1.29 1.33; do
    "$root/venv/bin/kubernetes-validate" --strict --kubernetes-version "$version" "$manifests"/*.yaml
done
sed 's/parallelism/paralelism/' "$manifests/shards.yaml" >"$root/misspelt.yaml"
if "$root/venv/bin/kubernetes-validate" --strict "$root/misspelt.yaml" 2>/dev/null; then
    echo "FAILED: a misspelt manifest passes" >&2
    exit 1
fi

# The command of a manifest, on less and elsewhere.
command_of() {
    "$root/venv/bin/python" -c '
import sys, yaml
print(yaml.safe_load(open(sys.argv[1]))["spec"]["template"]["spec"]["containers"][0]["args"][0])
' "$manifests/$1" | sed "s|/data/|$root/data/|g; s|synthetic:10000 --profile full|synthetic:4 --profile smoke|"
}
mkdir "$root/bin" "$root/data"
ln -s "$(realpath "$XTASK")" "$root/bin/xtask"
export PATH=$root/bin:$PATH SHARDS=3 THREADS=1
xtask dataset --maps synthetic:4 --profile smoke --out "$root/whole" >/dev/null
for index in 2 0 1; do
    JOB_COMPLETION_INDEX=$index sh -c "$(command_of shards.yaml)"
done
sh -c "$(command_of merge.yaml)"
diff --recursive "$root/whole" "$root/data/map2aps"
echo "manifests are valid, and make the same bytes"
