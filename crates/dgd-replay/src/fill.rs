//! Inputs without holes: a simulation needs a value at every instant.

/// Interpolates over values that are not finite, holding the nearest at the ends.
///
/// Returns how many were filled; `None` if there is no finite value at all.
///
/// ```
/// let mut values = [f64::NAN, 1.0, f64::NAN, f64::NAN, 4.0];
/// assert_eq!(dgd_replay::fill_gaps(&mut values), Some(3));
/// assert_eq!(values, [1.0, 1.0, 2.0, 3.0, 4.0]);
/// ```
pub fn fill_gaps(values: &mut [f64]) -> Option<usize> {
    let first = values.iter().position(|v| v.is_finite())?;
    let mut filled = first;
    let opening = values[first];
    values[..first].fill(opening);
    let mut last = first;
    for index in first + 1..values.len() {
        if !values[index].is_finite() {
            filled += 1;
            continue;
        }
        let (from, to) = (values[last], values[index]);
        let span = (index - last) as f64;
        for (step, value) in values[last + 1..index].iter_mut().enumerate() {
            *value = from + (to - from) * (step + 1) as f64 / span;
        }
        last = index;
    }
    let closing = values[last];
    values[last + 1..].fill(closing);
    Some(filled)
}
