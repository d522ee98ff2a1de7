//! Ctrl-C and the like end a run cleanly: no hidden file stays, a line says so, and the status is 128 and the signal.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// What must go if the run is ended from outside.
struct State {
    hidden: Vec<PathBuf>,
    /// Files that stand in their places.
    written: usize,
}

static STATE: Mutex<State> = Mutex::new(State {
    hidden: Vec::new(),
    written: 0,
});

/// While this lives, a signal waits.
pub(crate) struct Held(MutexGuard<'static, State>);

/// Lets a signal wait: for steps that must not be parted.
pub(crate) fn hold() -> Held {
    Held(STATE.lock().unwrap_or_else(PoisonError::into_inner))
}

impl Held {
    /// This file goes if the run is ended.
    pub(crate) fn remember(&mut self, hidden: &Path) {
        self.0.hidden.push(hidden.to_owned());
    }

    pub(crate) fn forget(&mut self, hidden: &Path) {
        self.0.hidden.retain(|path| path != hidden);
    }

    /// So many files have taken their places.
    pub(crate) fn written(mut self, files: usize) {
        self.0.written += files;
    }
}

/// Waits for signals on a thread of its own.
///
/// A second one ends the run at once. A file larger than the user's limit becomes an error like that of a full disk.
#[cfg(unix)]
pub(crate) fn watch() {
    use signal_hook::consts::{SIGINT, SIGTERM, SIGXFSZ};
    use signal_hook::flag;
    use std::sync::Arc;
    use std::sync::atomic::AtomicBool;

    // The run goes on as it would have without: such signals end it, and the next run clears up.
    let Ok(mut signals) = signal_hook::iterator::Signals::new([SIGINT, SIGTERM]) else {
        return;
    };
    let _ = flag::register(SIGXFSZ, Arc::default());
    let seen = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM] {
        // In this order: the first signal arms the second.
        let _ = flag::register_conditional_default(signal, Arc::clone(&seen));
        let _ = flag::register(signal, Arc::clone(&seen));
    }
    std::thread::spawn(move || {
        if let Some(signal) = signals.forever().next() {
            end(signal);
        }
    });
}

#[cfg(not(unix))]
pub(crate) fn watch() {}

/// Removes the hidden files and ends the run.
#[cfg(unix)]
fn end(signal: i32) {
    use std::io::{IsTerminal, Write};
    let held = hold();
    for path in &held.0.hidden {
        let _ = std::fs::remove_file(path);
    }
    let what = if signal == signal_hook::consts::SIGINT {
        "interrupted"
    } else {
        "terminated"
    };
    let state = match held.0.written {
        0 => "no output was written, no temporary file is left".to_owned(),
        1 => "one output had been written and is complete; no temporary file is left".to_owned(),
        n => format!("{n} outputs had been written and are complete; no temporary file is left"),
    };
    let mut stderr = std::io::stderr();
    // Below the line of progress, which may be half drawn.
    let newline = if stderr.is_terminal() { "\n" } else { "" };
    let _ = writeln!(stderr, "{newline}{what}: {state}");
    #[expect(
        clippy::exit,
        reason = "other threads are at work and need not end theirs"
    )]
    std::process::exit(128 + signal);
}
