/// Why a figure or a page was refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ReportError {
    /// Two slices that describe the same points differ in length.
    #[error("`{name}` has {found} values, expected {expected}")]
    Length {
        /// The slice that does not fit.
        name: &'static str,
        /// Length of the slice it belongs to.
        expected: usize,
        /// Its own length.
        found: usize,
    },
    /// An axis range given by the caller cannot be drawn.
    #[error("axis `{label}` runs from {low} to {high}, expected finite and increasing")]
    Range {
        /// Label of the axis.
        label: String,
        /// Lower end as given.
        low: f64,
        /// Upper end as given.
        high: f64,
    },
    /// A figure was asked to show more parts than fit on a page.
    #[error("{found} {what}, expected at most {most}")]
    TooMany {
        /// What there is too much of.
        what: &'static str,
        /// The number given.
        found: usize,
        /// The number that still fits.
        most: usize,
    },
    /// The scale would make the PNG empty or larger than [`MAX_PIXELS`](crate::MAX_PIXELS).
    #[error("scale {scale} makes {width:.0} x {height:.0} pixels, expected 1 to {most} in all")]
    Scale {
        /// Scale as given.
        scale: f64,
        /// Width it would make, pixels.
        width: f64,
        /// Height it would make, pixels.
        height: f64,
        /// Most pixels in all.
        most: u32,
    },
    /// The PNG encoder refused the picture.
    #[error("could not encode the PNG: {reason}")]
    Encode {
        /// The encoder's own words.
        reason: String,
    },
    /// A formula is not the plain MathML that a page accepts.
    #[error("formula refused at byte {at}: {reason}")]
    Formula {
        /// Byte offset in the formula.
        at: usize,
        /// What was found there.
        reason: &'static str,
    },
}
