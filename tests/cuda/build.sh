#!/usr/bin/env bash
# Builds the programs that tests/gpu.sh takes, for a GPU of compute capability 9.0 or CUDA_COMPUTE_CAP, on a machine without one:
#
#     tests/cuda/build.sh OUT
#
# CUDA's compiler and libraries come from PyPI (1.5 GB), the names of the driver's library, which comes with a driver, from the
# crate that calls them. The machine with the GPU needs the libraries of CUDA 13, as PyTorch brings them, and a driver for it.
set -euo pipefail
out=$(realpath -m "$1")
cd "$(dirname "$0")/../.."
target=${CARGO_TARGET_DIR:-target}
python3 -m venv "$target/python/cuda"
"$target/python/cuda/bin/pip" install --quiet -r tests/cuda/requirements.txt -r tests/cuda/libraries.txt
CUDA_HOME=$("$target/python/cuda/bin/python" -c 'import nvidia.cu13; print(*nvidia.cu13.__path__)')
export CUDA_HOME CUDA_COMPUTE_CAP=${CUDA_COMPUTE_CAP:-90} PATH=$CUDA_HOME/bin:$PATH

# As a linker looks for them.
for library in cublas cublasLt cudart curand nvrtc; do
    (cd "$CUDA_HOME/lib" && ln -sf "lib$library.so".* "lib$library.so")
done
host=$(rustc -vV | sed -n 's/^host: //p')
calls=$(cargo metadata --locked --all-features --filter-platform "$host" --format-version 1 | python3 -c '
import json, pathlib, sys
packages = json.load(sys.stdin)["packages"]
manifest = next(p["manifest_path"] for p in packages if p["name"] == "cudarc")
print(pathlib.Path(manifest).parent / "src/driver/sys/mod.rs")')
mkdir -p "$CUDA_HOME/lib/stubs" "$out"
grep -ohE 'fn cu[A-Z][A-Za-z0-9_]*' "$calls" | sort -u | sed 's/^fn \(.*\)/void \1(void) {}/' |
    cc -w -shared -Wl,-soname,libcuda.so.1 -o "$CUDA_HOME/lib/stubs/libcuda.so" -x c -

cargo build --release --features cuda -p xtask-models
cargo build --release --features cuda -p aps-model --example step_time --example device_parity
cargo build --release -p xtask
tests=$(cargo test --release --features cuda -p aps-model --lib --no-run --message-format json |
    python3 -c 'import json, sys; print(*{m["executable"] for m in map(json.loads, sys.stdin) if m.get("executable")})')
install --strip "$target"/release/{xtask,xtask-models} "$target"/release/examples/{step_time,device_parity} "$out"
install --strip "$tests" "$out/unit_tests"
du -sh "$out"
