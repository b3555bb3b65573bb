//! Ctrl-C as a request to end well.

use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::Result;

use crate::note;

/// Status of a program that Ctrl-C ended, as shells give it.
pub(crate) const STATUS: u8 = 130;

static IS_RAISED: AtomicBool = AtomicBool::new(false);

/// A flag that Ctrl-C raises; a second Ctrl-C ends the process at once. A process has one handler, so it asks once.
pub fn interrupt_flag() -> Result<&'static AtomicBool> {
    ctrlc::set_handler(|| {
        if IS_RAISED.swap(true, Ordering::Relaxed) {
            std::process::exit(STATUS.into());
        }
        note!("what is under way is finished first; Ctrl-C once more ends at once");
    })?;
    Ok(&IS_RAISED)
}

/// Tells if Ctrl-C was pressed, in a process that takes it as a request.
pub(crate) fn was_interrupted() -> bool {
    IS_RAISED.load(Ordering::Relaxed)
}
