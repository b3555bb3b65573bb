//! Ctrl-C as a request to end well.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

use anyhow::Result;

use crate::note;

/// Status of a program that Ctrl-C ended, as shells give it.
pub(crate) const STATUS: u8 = 130;

static IS_RAISED: AtomicBool = AtomicBool::new(false);

/// True once somebody asked for the flag: a process has one handler.
static IS_HANDLED: Mutex<bool> = Mutex::new(false);

/// A flag that Ctrl-C raises, the same for whoever asks; a second Ctrl-C ends the process at once.
pub fn interrupt_flag() -> Result<&'static AtomicBool> {
    let mut is_handled = IS_HANDLED.lock().unwrap_or_else(PoisonError::into_inner);
    if !*is_handled {
        ctrlc::set_handler(|| {
            if IS_RAISED.swap(true, Ordering::Relaxed) {
                std::process::exit(STATUS.into());
            }
            note!("what is under way is finished first; Ctrl-C once more ends at once");
        })?;
        *is_handled = true;
    }
    Ok(&IS_RAISED)
}

/// Tells if Ctrl-C was pressed, in a process that takes it as a request.
pub(crate) fn was_interrupted() -> bool {
    IS_RAISED.load(Ordering::Relaxed)
}
