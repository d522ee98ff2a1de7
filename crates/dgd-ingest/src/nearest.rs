//! Readings of one source at the stamps of another.

/// For each stamp of the busiest source the nearest reading of another one, and the farthest move; both in ns.
///
/// Nearest, not last: holding the last value would delay one source against the other by
/// up to a step, which looks like a slow instrument. A reading farther than 0.6 steps of
/// the slower source is no neighbour. Of readings with one stamp the last counts.
pub(crate) fn nearest(of_ns: &[u64], at_ns: &[u64]) -> (Vec<Option<usize>>, u64) {
    let reach = median_step(of_ns).max(median_step(at_ns)) / 5 * 3;
    let mut farthest = 0;
    let mut next = 0;
    let mut before = 0;
    let in_order = of_ns.is_sorted();
    let sources = at_ns.iter().map(|at| {
        // Where the clock of the busiest was set back, the readings of its second stretch are behind. One that was set back
        // itself is walked on as logged.
        if *at < before && in_order {
            next = of_ns.partition_point(|ns| ns <= at).saturating_sub(1);
        }
        before = *at;
        while of_ns
            .get(next + 1)
            // Readings that share a stamp are equally near: what is behind them must not stay out of reach.
            .is_some_and(|ns| *ns == of_ns[next] || ns.abs_diff(*at) < of_ns[next].abs_diff(*at))
        {
            next += 1;
        }
        let distance = of_ns.get(next)?.abs_diff(*at);
        if distance > reach {
            return None;
        }
        farthest = farthest.max(distance);
        Some(next)
    });
    let sources = sources.collect();
    (sources, farthest)
}

/// Median of the steps that are longer than none; 0 without one.
pub(crate) fn median_step(ns: &[u64]) -> u64 {
    let mut steps: Vec<u64> = ns
        .windows(2)
        // A source whose clock was set back is left as logged.
        .map(|w| w[1].saturating_sub(w[0]))
        .filter(|s| *s > 0)
        .collect();
    if steps.is_empty() {
        return 0;
    }
    let middle = steps.len() / 2;
    *steps.select_nth_unstable(middle).1
}
