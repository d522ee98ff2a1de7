//! How far a long run is, on standard error.

use std::io::{self, IsTerminal, Write};

/// Tells how many of some cases are made: in one line that renews itself on a terminal, by every hundredth case and the last elsewhere.
pub(crate) fn progress(done: usize, of: usize) {
    let mut to = io::stderr();
    let ended = done == of;
    // Progress is a courtesy: nothing is lost if nobody listens.
    let _ = if to.is_terminal() {
        write!(to, "\r{done} of {of}{}", if ended { "\n" } else { "" })
    } else if ended || done.is_multiple_of(100) {
        writeln!(to, "{done} of {of}")
    } else {
        Ok(())
    };
}
