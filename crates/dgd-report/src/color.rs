//! Colours: one meaning, one colour, told apart by colour-blind eyes and by their lightness in grey print.

/// What a curve or a point stands for. The same role has the same colour in every figure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Role {
    /// Read from an instrument: near black.
    Measured,
    /// Computed by the model (or, after a diagnosis, by the repaired model): blue.
    Model,
    /// The model before it was changed: orange, dashed.
    Before,
    /// Samples the screening took out: light red.
    Rejected,
    /// The n-th input or side quantity: teal, purple, olive, then again.
    Input(u8),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Color(pub u8, pub u8, pub u8);

pub(crate) const INK: Color = Color(0x26, 0x2b, 0x33);
pub(crate) const SOFT_INK: Color = Color(0x5b, 0x63, 0x6e);
pub(crate) const GRID: Color = Color(0xe7, 0xea, 0xee);
pub(crate) const FRAME: Color = Color(0x9a, 0xa1, 0xab);
pub(crate) const PAPER: Color = Color(0xff, 0xff, 0xff);
pub(crate) const SHADE: Color = Color(0xe8, 0xe4, 0xf4);

impl Role {
    pub(crate) fn color(self) -> Color {
        match self {
            Self::Measured => Color(0x38, 0x3c, 0x42),
            Self::Model => Color(0x1b, 0x62, 0xb5),
            Self::Before => Color(0xdd, 0x7d, 0x0f),
            Self::Rejected => Color(0xe8, 0x8f, 0x85),
            Self::Input(n) => [
                Color(0x11, 0x8a, 0x7e),
                Color(0x85, 0x4f, 0xa8),
                Color(0x8a, 0x7a, 0x1e),
            ][usize::from(n % 3)],
        }
    }

    pub(crate) fn dash(self) -> Option<[f64; 2]> {
        (self == Self::Before).then_some([6.0, 3.5])
    }

    /// Measured lines lie under the model's and are wider, so that a perfect fit still shows both.
    pub(crate) fn width(self) -> f64 {
        match self {
            Self::Measured => 1.9,
            Self::Model | Self::Before => 1.7,
            Self::Rejected | Self::Input(_) => 1.5,
        }
    }
}

/// `share` of the colour on white paper, 0 to 1. Opaque, so overlapping points do not pile up.
pub(crate) fn tone(color: Color, share: f64) -> Color {
    mix(PAPER, color, share)
}

/// A point on the viridis scale without its palest end, `at` from 0 to 1.
pub(crate) fn sequence(at: f64) -> Color {
    const STOPS: [Color; 7] = [
        Color(0x44, 0x15, 0x5f),
        Color(0x44, 0x3a, 0x83),
        Color(0x31, 0x68, 0x8e),
        Color(0x21, 0x90, 0x8d),
        Color(0x35, 0xb0, 0x79),
        Color(0x76, 0xc2, 0x4a),
        Color(0xc4, 0xbe, 0x1c),
    ];
    let at = if at.is_finite() {
        at.clamp(0.0, 1.0)
    } else {
        0.0
    };
    let place = at * 6.0;
    let left = (0..6).rev().find(|&i| place >= f64::from(i)).unwrap_or(0);
    let index = usize::try_from(left).unwrap_or(0);
    mix(STOPS[index], STOPS[index + 1], place - f64::from(left))
}

fn mix(from: Color, to: Color, share: f64) -> Color {
    let share = share.clamp(0.0, 1.0);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "between two bytes"
    )]
    let one = |a: u8, b: u8| (f64::from(a) + (f64::from(b) - f64::from(a)) * share).round() as u8;
    Color(one(from.0, to.0), one(from.1, to.1), one(from.2, to.2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sequence_starts_and_ends_at_its_first_and_last_stop() {
        assert_eq!(sequence(0.0), Color(0x44, 0x15, 0x5f));
        assert_eq!(sequence(1.0), Color(0xc4, 0xbe, 0x1c));
        assert_eq!(sequence(f64::NAN), sequence(0.0));
    }

    #[test]
    fn the_sequence_grows_lighter() {
        let light =
            |c: Color| 0.2126 * f64::from(c.0) + 0.7152 * f64::from(c.1) + 0.0722 * f64::from(c.2);
        let all: Vec<f64> = (0..=20)
            .map(|i| light(sequence(f64::from(i) / 20.0)))
            .collect();
        assert!(all.windows(2).all(|pair| pair[0] < pair[1]));
    }
}
