//! The machine and the build.

use std::process::Command;
use std::time::SystemTime;

use sysinfo::{CpuRefreshKind, MemoryRefreshKind, RefreshKind, System};

use crate::benchmark::Machine;

/// What can be found out about them; what cannot is left empty.
pub fn describe() -> Machine {
    let what = RefreshKind::nothing()
        .with_cpu(CpuRefreshKind::nothing())
        .with_memory(MemoryRefreshKind::nothing().with_ram());
    let system = System::new_with_specifics(what);
    Machine {
        cpu: system
            .cpus()
            .first()
            .map_or(String::new(), |cpu| cpu.brand().trim().into()),
        cores: std::thread::available_parallelism().map_or(0, usize::from),
        threads: rayon::current_num_threads(),
        memory_bytes: system.total_memory(),
        os: System::long_os_version().unwrap_or(std::env::consts::OS.into()),
        rustc: env!("BUILD_RUSTC_VERSION").into(),
        version: env!("CARGO_PKG_VERSION").into(),
        commit: commit(),
        started: humantime::format_rfc3339_seconds(SystemTime::now()).to_string(),
        seconds_total: 0.0,
    }
}

/// The commit of the sources this was built from, marked if they were changed since.
fn commit() -> String {
    let git = Command::new("git")
        .args([
            "describe",
            "--always",
            "--dirty",
            "--abbrev=12",
            "--exclude=*",
        ])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output();
    match git {
        Ok(output) if output.status.success() => {
            String::from_utf8_lossy(&output.stdout).trim().into()
        }
        _ => String::new(),
    }
}
