//! Progress for a person who waits, and the number of threads that work for it.

use anyhow::{Result, ensure};
use indicatif::{ProgressBar, ProgressStyle};

/// A bar over `count` things of the given name.
pub fn bar(count: u64, things: &str) -> ProgressBar {
    let template = format!(
        "{{msg:8}} [{{bar:40}}] {{human_pos}}/{{human_len}} {things}, {{per_sec}}, {{eta}} left"
    );
    let style = ProgressStyle::with_template(&template)
        .expect("the template is well formed")
        .progress_chars("=> ");
    ProgressBar::new(count).with_style(style)
}

/// Sets the number of threads, if one is given.
pub fn use_threads(threads: Option<usize>) -> Result<()> {
    if let Some(threads) = threads {
        ensure!(threads > 0, "--threads must be at least 1");
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build_global()?;
    }
    Ok(())
}
