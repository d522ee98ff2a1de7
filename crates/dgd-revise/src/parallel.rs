//! The same work on many items, on rayon's threads; results in the order of the items, whatever the threads did.

use rayon::prelude::*;

/// Where the work is done.
pub(crate) struct Threads(Option<rayon::ThreadPool>);

impl Threads {
    /// So many threads of their own; all of the machine, shared with whoever else asks, if 0.
    pub(crate) fn new(threads: usize) -> Self {
        let own = rayon::ThreadPoolBuilder::new().num_threads(threads);
        // Where no thread can be started the answer is the same, only later.
        Self((threads > 0).then(|| own.build().ok()).flatten())
    }

    /// `f` of each item.
    pub(crate) fn map<T: Sync, R: Send>(&self, items: &[T], f: impl Fn(&T) -> R + Sync) -> Vec<R> {
        let all = || items.par_iter().with_max_len(1).map(&f).collect();
        match &self.0 {
            Some(own) => own.install(all),
            None => all(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_stand_in_the_order_of_the_items() {
        let items: Vec<u32> = (0..100).collect();
        let twice = |i: &u32| i * 2;
        let one = Threads::new(1).map(&items, twice);
        assert_eq!(Threads::new(4).map(&items, twice), one);
        assert_eq!(Threads::new(0).map(&items, twice), one);
        assert_eq!(one[99], 198);
    }
}
