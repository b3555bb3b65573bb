//! Ctrl-C as a request to end well.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

use anyhow::Result;

use crate::note;

/// Status of a program that Ctrl-C ended, as shells give it.
pub(crate) const STATUS: u8 = 130;

/// The flag of this process, once somebody asked for it: a process has one handler.
static FLAG: Mutex<Option<Arc<AtomicBool>>> = Mutex::new(None);

/// A flag that Ctrl-C raises, the same for whoever asks; a second Ctrl-C ends the process at once.
pub fn interrupt_flag() -> Result<Arc<AtomicBool>> {
    let mut known = FLAG.lock().unwrap_or_else(|e| e.into_inner());
    if let Some(flag) = &*known {
        return Ok(Arc::clone(flag));
    }
    let flag = Arc::new(AtomicBool::new(false));
    let raised = Arc::clone(&flag);
    ctrlc::set_handler(move || {
        if raised.swap(true, Ordering::Relaxed) {
            std::process::exit(STATUS.into());
        }
        note!("what is under way is finished first; Ctrl-C once more ends at once");
    })?;
    *known = Some(Arc::clone(&flag));
    Ok(flag)
}

/// Tells if Ctrl-C was pressed, in a process that takes it as a request.
pub(crate) fn was_interrupted() -> bool {
    let known = FLAG.lock().unwrap_or_else(|e| e.into_inner());
    known
        .as_ref()
        .is_some_and(|flag| flag.load(Ordering::Relaxed))
}
