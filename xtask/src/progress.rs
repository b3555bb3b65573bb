//! Progress for a person who waits, and the number of threads that work for it.

use std::sync::OnceLock;

use anyhow::{Result, ensure};
use indicatif::{ProgressBar, ProgressStyle};
use map2aps::{Control, Progress, Work};

use crate::interrupt::interrupt_flag;
use crate::note;

/// A bar over `count` things of the given name.
pub fn bar(count: u64, things: &str) -> ProgressBar {
    let template = format!(
        "{{msg:8}} [{{bar:40}}] {{human_pos}}/{{human_len}} {things}, {{per_sec}}, {{eta}} left"
    );
    bar_of(count, &template)
}

/// A bar over `count` things, shown by a template of `indicatif`.
///
/// # Panics
/// For a template that is none.
pub fn bar_of(count: u64, template: &str) -> ProgressBar {
    let style = ProgressStyle::with_template(template).expect("the template is well formed");
    ProgressBar::new(count).with_style(style.progress_chars("=> "))
}

/// The bar of an operation of the library, from the moment it begins.
#[derive(Debug, Default)]
pub struct Bar(OnceLock<ProgressBar>);

impl Bar {
    /// Control of an operation that shows this bar, that Ctrl-C ends and that `command` continues.
    pub fn control<'a>(&'a self, command: &'a [String]) -> Result<Control<'a>> {
        Ok(Control {
            progress: self,
            cancel: interrupt_flag()?,
            command,
        })
    }

    /// Removes the bar.
    pub fn clear(&self) {
        if let Some(bar) = self.0.get() {
            bar.finish_and_clear();
        }
    }

    /// Prints without disturbing the bar.
    pub fn suspend<R>(&self, print: impl FnOnce() -> R) -> R {
        match self.0.get() {
            Some(bar) => bar.suspend(print),
            None => print(),
        }
    }
}

impl Progress for Bar {
    fn begin(&self, work: Work) {
        if work.finished_maps > 0 {
            let (finished, all) = (work.finished_maps, work.maps);
            note!("{finished} of {all} maps are there already");
        }
        self.0.get_or_init(|| bar(work.units, work.name));
    }

    fn map(&self, id: u32) {
        if let Some(bar) = self.0.get() {
            bar.set_message(format!("map {id}"));
        }
    }

    fn advance(&self, units: u64) {
        if let Some(bar) = self.0.get() {
            bar.inc(units);
        }
    }
}

/// Threads that no machine runs better with more of.
const MAX_THREADS: usize = 4096;

/// Sets the number of threads, if one is given.
pub fn use_threads(threads: Option<usize>) -> Result<()> {
    if let Some(threads) = threads {
        ensure!(
            (1..=MAX_THREADS).contains(&threads),
            "--threads {threads}: must be 1 to {MAX_THREADS}"
        );
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build_global()?;
    }
    Ok(())
}
