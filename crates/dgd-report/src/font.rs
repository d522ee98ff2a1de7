//! The one font: widths for the layout, outlines for the PNG.
//!
//! A machine need not have any font. In an SVG the text stays text, with metric twins named as fallbacks.

use ttf_parser::{Face, GlyphId};

static REGULAR: &[u8] = include_bytes!("../assets/Arimo-Regular.ttf");
static BOLD: &[u8] = include_bytes!("../assets/Arimo-Bold.ttf");

/// Fonts with the same widths, most wanted first.
pub(crate) const FAMILY: &str = "Arimo, Arial, 'Liberation Sans', Helvetica, sans-serif";

pub(crate) struct Font {
    face: Face<'static>,
}

impl Font {
    /// `None` only if the shipped file is damaged; a test reads both.
    pub(crate) fn load(bold: bool) -> Option<Self> {
        let face = Face::parse(if bold { BOLD } else { REGULAR }, 0).ok()?;
        Some(Self { face })
    }

    /// Each glyph of `text` with its pen position, for a font size of 1.
    pub(crate) fn glyphs<'a>(&'a self, text: &'a str) -> impl Iterator<Item = (GlyphId, f64)> + 'a {
        let em = f64::from(self.face.units_per_em());
        text.chars().scan(0.0, move |pen, letter| {
            // Glyph 0 is the empty box: a letter we lack is seen to be lacking.
            let glyph = self.face.glyph_index(letter).unwrap_or(GlyphId(0));
            let at = *pen;
            *pen += f64::from(self.face.glyph_hor_advance(glyph).unwrap_or(0)) / em;
            Some((glyph, at))
        })
    }

    pub(crate) fn face(&self) -> &Face<'static> {
        &self.face
    }

    pub(crate) fn units_per_em(&self) -> f64 {
        f64::from(self.face.units_per_em())
    }

    fn width(&self, text: &str) -> f64 {
        let em = self.units_per_em();
        text.chars()
            .map(|letter| self.face.glyph_index(letter).unwrap_or(GlyphId(0)))
            .map(|glyph| f64::from(self.face.glyph_hor_advance(glyph).unwrap_or(0)) / em)
            .sum()
    }
}

/// CSS that carries both fonts, for a page that looks the same wherever it is opened.
pub(crate) fn css() -> String {
    let face = |weight: &str, data: &[u8]| {
        format!(
            "@font-face {{ font-family: Arimo; font-weight: {weight}; src: url(data:font/ttf;base64,{}); }}\n",
            base64(data)
        )
    };
    face("normal", REGULAR) + &face("bold", BOLD)
}

fn base64(data: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = String::with_capacity(data.len().div_ceil(3) * 4);
    for three in data.chunks(3) {
        let byte = |i: usize| usize::from(three.get(i).copied().unwrap_or(0));
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        for place in 0..4 {
            let letter = char::from(LETTERS[bits >> (18 - 6 * place) & 63]);
            out.push(if place > three.len() { '=' } else { letter });
        }
    }
    out
}

/// Width of `text` in figure units at `size`.
pub(crate) fn text_width(text: &str, size: f64, bold: bool) -> f64 {
    // Without the font, 0.56 em is Arial's mean width.
    Font::load(bold).map_or_else(
        || text.chars().map(|_| 0.56).sum::<f64>(),
        |font| font.width(text),
    ) * size
}

/// `text`, cut with an ellipsis where it would be wider than `room`.
pub(crate) fn shorten(text: &str, size: f64, room: f64) -> String {
    if text_width(text, size, false) <= room {
        return text.to_owned();
    }
    let mut short = String::new();
    for letter in text.chars() {
        short.push(letter);
        if text_width(&short, size, false) + size > room {
            short.pop();
            break;
        }
    }
    format!("{}…", short.trim_end())
}

/// `text` in lines no wider than `room`; a longer word stands alone.
pub(crate) fn wrap(text: &str, size: f64, room: f64, first_indent: f64) -> Vec<String> {
    let mut lines = vec![String::new()];
    let mut used = first_indent;
    let space = text_width(" ", size, false);
    for word in text.split_whitespace() {
        let width = text_width(word, size, false);
        let line_is_empty = lines.last().is_none_or(String::is_empty);
        if used + space + width > room && !(line_is_empty && used == 0.0) {
            lines.push(String::new());
            used = 0.0;
        }
        if let Some(line) = lines.last_mut() {
            if !line.is_empty() {
                line.push(' ');
                used += space;
            }
            line.push_str(word);
            used += width;
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_shipped_fonts_hold_the_letters_of_our_figures() {
        for bold in [false, true] {
            let Some(font) = Font::load(bold) else {
                panic!("font is damaged")
            };
            for letter in "Aåøæ09[%]±·×−–…²³₀₂θωρΔ≤≥°µ".chars() {
                assert!(font.face.glyph_index(letter).is_some(), "{letter}");
            }
        }
    }

    #[test]
    fn widths_are_those_of_arial() {
        // Arial: digit 1139/2048, "M" 1706/2048.
        assert!((text_width("0", 2048.0, false) - 1139.0).abs() < 1.0);
        assert!((text_width("M", 2048.0, false) - 1706.0).abs() < 1.0);
    }

    #[test]
    fn wrapped_lines_keep_every_word_and_the_width() {
        let text = "one two three four five six seven eight nine ten";
        let lines = wrap(text, 10.0, 80.0, 20.0);
        assert_eq!(lines.join(" "), text);
        assert!(
            lines
                .iter()
                .all(|line| text_width(line, 10.0, false) <= 80.0)
        );
    }

    #[test]
    fn base64_as_in_rfc_4648() {
        let all =
            ["", "f", "fo", "foo", "foob", "fooba", "foobar"].map(|text| base64(text.as_bytes()));
        assert_eq!(
            all,
            [
                "", "Zg==", "Zm8=", "Zm9v", "Zm9vYg==", "Zm9vYmE=", "Zm9vYmFy"
            ]
        );
    }

    #[test]
    fn a_shortened_label_fits() {
        let short = shorten("a label that is far too long", 12.0, 60.0);
        assert!(short.ends_with('…') && text_width(&short, 12.0, false) <= 60.0);
    }
}
