//! Long work: on all cores, without Python's lock, ended by Ctrl-C.

use std::mem;
use std::panic::{self, AssertUnwindSafe};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use map2aps::{Control, Error, Progress, Work};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::error::exception;

/// Time between two looks for Ctrl-C.
const TICK: Duration = Duration::from_millis(50);

/// The threads of this process. A forked process has none of its parent's, so it makes its own.
static POOL: Mutex<Option<(u32, Arc<ThreadPool>)>> = Mutex::new(None);

fn pool() -> PyResult<Arc<ThreadPool>> {
    // Only whoever holds Python's lock comes here, and forks too, so that no process is born with this one taken.
    let mut pool = POOL.lock().unwrap_or_else(PoisonError::into_inner);
    let process = std::process::id();
    if let Some((_, own)) = pool.as_ref().filter(|(owner, _)| *owner == process) {
        return Ok(Arc::clone(own));
    }
    let made = ThreadPoolBuilder::new().build();
    let made = Arc::new(made.map_err(|e| PyRuntimeError::new_err(e.to_string()))?);
    // Ending the parent's threads here would wait for locks that nobody gives back.
    mem::forget(pool.replace((process, Arc::clone(&made))));
    Ok(made)
}

/// Counts what is done, for whoever looks.
#[derive(Default)]
struct Counter {
    done: AtomicU64,
    units: AtomicU64,
}

impl Progress for Counter {
    fn begin(&self, work: Work) {
        self.units.store(work.units, Ordering::Relaxed);
    }

    fn advance(&self, units: u64) {
        self.done.fetch_add(units, Ordering::Relaxed);
    }
}

impl Counter {
    fn tell(&self, py: Python<'_>, callback: Option<&Py<PyAny>>) -> PyResult<()> {
        let [done, units] = [&self.done, &self.units].map(|n| n.load(Ordering::Relaxed));
        match callback {
            Some(callback) if units > 0 => callback.call1(py, (done, units)).map(drop),
            _ => Ok(()),
        }
    }
}

/// Runs work on all threads and waits for it. Ctrl-C cancels it, and so does an exception of `progress`, which is called with the
/// units done and those to do, by this thread.
pub fn run<T: Send>(
    py: Python<'_>,
    progress: Option<&Py<PyAny>>,
    work: impl FnOnce(&Control<'_>) -> Result<T, Error> + Send,
) -> PyResult<T> {
    let pool = pool()?;
    let (counter, cancel) = (Counter::default(), AtomicBool::new(false));
    let mut stopped: Option<PyErr> = None;
    let outcome = py.detach(|| {
        let (send, receive) = mpsc::channel();
        let (counter, cancel) = (&counter, &cancel);
        pool.in_place_scope(|scope| {
            scope.spawn(move |_| {
                let control = Control {
                    progress: counter,
                    cancel,
                    ..Control::default()
                };
                // Nobody waits any longer only where this thread panicked.
                let _ = send.send(work(&control));
            });
            loop {
                match receive.recv_timeout(TICK) {
                    Ok(outcome) => break Some(outcome),
                    // The work panicked: the scope goes on with that.
                    Err(RecvTimeoutError::Disconnected) => break None,
                    Err(RecvTimeoutError::Timeout) if stopped.is_some() => {}
                    Err(RecvTimeoutError::Timeout) => {
                        let look = |py: Python<'_>| {
                            py.check_signals()?;
                            counter.tell(py, progress)
                        };
                        if let Err(error) = Python::attach(look) {
                            stopped = Some(error);
                            cancel.store(true, Ordering::Relaxed);
                        }
                    }
                }
            }
        })
    });
    if let Some(error) = stopped {
        return Err(error);
    }
    let outcome = outcome.expect("a panic went on").map_err(exception)?;
    counter.tell(py, progress)?;
    Ok(outcome)
}

/// Runs work that holds all that it needs on all threads, and waits for it. It cannot be cancelled: Ctrl-C leaves it, and its threads
/// end it unheard.
pub fn run_owned<T: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce() -> Result<T, Error> + Send + 'static,
) -> PyResult<T> {
    let (send, receive) = mpsc::channel();
    pool()?.spawn(move || {
        // Nobody waits any longer after Ctrl-C.
        let _ = send.send(panic::catch_unwind(AssertUnwindSafe(work)));
    });
    py.detach(move || {
        loop {
            match receive.recv_timeout(TICK) {
                Ok(Ok(outcome)) => break outcome.map_err(exception),
                Ok(Err(panicked)) => panic::resume_unwind(panicked),
                Err(RecvTimeoutError::Disconnected) => unreachable!("it sends before it ends"),
                Err(RecvTimeoutError::Timeout) => Python::attach(|py| py.check_signals())?,
            }
        }
    })
}
