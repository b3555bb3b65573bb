//! The machine and the build.

use std::process::Command;
use std::time::SystemTime;

use sysinfo::{CpuRefreshKind, MemoryRefreshKind, RefreshKind, System};

use aps_report::benchmark::Machine;

/// Describes both, as far as can be found out; the rest is left empty.
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

/// The commit of the sources this was built from, marked if they were changed since. Reports are not among them: one
/// that is being written leaves the sources as they are.
fn commit() -> String {
    let Some(commit) = git(&["rev-parse", "--short=12", "HEAD"]) else {
        return String::new();
    };
    let changes = git(&[
        "status",
        "--porcelain",
        "--untracked-files=no",
        "--",
        ":(top)",
        ":(top,exclude)docs/reports",
    ]);
    match changes.as_deref() {
        Some("") => commit,
        _ => commit + "-dirty",
    }
}

/// The answer of git, if it is there and this is a checkout.
fn git(args: &[&str]) -> Option<String> {
    let mut git = Command::new("git");
    git.args(args).current_dir(env!("CARGO_MANIFEST_DIR"));
    let output = git.output().ok().filter(|o| o.status.success())?;
    Some(String::from_utf8_lossy(&output.stdout).trim().into())
}
