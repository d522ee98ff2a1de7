//! Work that goes on side by side where a core is idle, with the same digits as one after the other.

use rayon::prelude::*;

/// Whether a core may be idle.
///
/// Within a task of the pool work goes on alone: a worker that waits here would take on another task meanwhile, whose columns would
/// stand in memory beside these.
pub(crate) fn idle() -> bool {
    rayon::current_thread_index().is_none()
}

/// Of each item, in their order.
pub(crate) fn each<T: Send, R: Send>(items: Vec<T>, of: impl Fn(T) -> R + Send + Sync) -> Vec<R> {
    if idle() {
        items.into_par_iter().map(of).collect()
    } else {
        items.into_iter().map(of).collect()
    }
}

/// Of each item, in their order, wherever it is asked: for what is dear and not alike, so that each is handed out alone.
///
/// A worker that waits for the last of them may take on another task of the pool meanwhile, and hold its columns beside its own.
pub(crate) fn apiece<T: Send, R: Send>(items: Vec<T>, of: impl Fn(T) -> R + Send + Sync) -> Vec<R> {
    items.into_par_iter().with_max_len(1).map(of).collect()
}

/// Both.
pub(crate) fn both<A: Send, B: Send>(
    one: impl FnOnce() -> A + Send,
    other: impl FnOnce() -> B + Send,
) -> (A, B) {
    if idle() {
        rayon::join(one, other)
    } else {
        (one(), other())
    }
}

#[cfg(test)]
mod tests {
    use super::{apiece, both, each, idle};

    #[test]
    fn answers_come_in_order_whether_a_core_is_idle_or_not() {
        let squares = || each((0..100).collect(), |k: u64| k * k);
        let expected: Vec<u64> = (0..100).map(|k| k * k).collect();
        assert!(idle());
        assert_eq!(squares(), expected);
        assert_eq!(apiece((0..100).collect(), |k: u64| k * k), expected);
        assert_eq!(both(|| 1, || "two"), (1, "two"));
        // Within the pool all goes on where it is.
        let (here, there) = rayon::join(
            || (idle(), squares(), both(|| 1, || "two")),
            || each(vec![(); 8], |()| rayon::current_thread_index()),
        );
        assert_eq!(here, (false, expected, (1, "two")));
        assert!(there.windows(2).all(|pair| pair[0] == pair[1]));
    }
}
