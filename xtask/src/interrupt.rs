//! Ctrl-C as a request to end well.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

use anyhow::Result;

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
            std::process::exit(130);
        }
    })?;
    *known = Some(Arc::clone(&flag));
    Ok(flag)
}
