//! A small writer of SVG: shapes, text, nothing else.

use std::fmt::Write;

pub(crate) const INK: &str = "#1c2733";
pub(crate) const FAINT: &str = "#8794a1";
pub(crate) const GRID: &str = "#dfe5ea";
pub(crate) const BLUE: &str = "#1f6fb2";
pub(crate) const RED: &str = "#b8442a";
pub(crate) const GREEN: &str = "#2f7d5b";

pub(crate) struct Svg {
    width: f64,
    height: f64,
    title: String,
    body: String,
}

/// Where text stands at its point.
#[derive(Clone, Copy)]
pub(crate) enum Anchor {
    Start,
    Middle,
    End,
}

impl Svg {
    /// The title is read out where the picture cannot be seen.
    pub(crate) fn new(width: f64, height: f64, title: &str) -> Svg {
        Svg {
            width,
            height,
            title: escape(title),
            body: String::new(),
        }
    }

    /// Grid, ticks and diagonal of a reliability diagram, whose places on the page `x` and `y` tell.
    pub(crate) fn reliability_frame(&mut self, x: impl Fn(f64) -> f64, y: impl Fn(f64) -> f64) {
        for p in [0.0, 0.25, 0.5, 0.75, 1.0] {
            self.line((x(0.0), y(p)), (x(1.0), y(p)), GRID, 1.0);
            self.line((x(p), y(0.0)), (x(p), y(1.0)), GRID, 1.0);
            let tick = p.to_string();
            self.text((x(0.0) - 6.0, y(p) + 4.0), Anchor::End, FAINT, &tick);
            self.text((x(p), y(0.0) + 16.0), Anchor::Middle, FAINT, &tick);
        }
        self.line((x(0.0), y(0.0)), (x(1.0), y(1.0)), FAINT, 1.0);
        let under = (x(0.5), y(0.0) + 34.0);
        self.text(under, Anchor::Middle, INK, "probability stated");
    }

    pub(crate) fn rect(&mut self, (x, y): (f64, f64), (w, h): (f64, f64), fill: &str) {
        self.put(format_args!(
            "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{w:.1}\" height=\"{h:.1}\" fill=\"{fill}\"/>"
        ));
    }

    pub(crate) fn line(&mut self, a: (f64, f64), b: (f64, f64), stroke: &str, width: f64) {
        self.put(format_args!(
            "<line x1=\"{:.1}\" y1=\"{:.1}\" x2=\"{:.1}\" y2=\"{:.1}\" stroke=\"{stroke}\" stroke-width=\"{width}\"/>",
            a.0, a.1, b.0, b.1
        ));
    }

    /// `dash`: as in SVG, `none` for a full line.
    pub(crate) fn polyline(&mut self, points: &[(f64, f64)], stroke: &str, dash: &str) {
        let points: Vec<String> = points
            .iter()
            .map(|(x, y)| format!("{x:.1},{y:.1}"))
            .collect();
        self.put(format_args!(
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{stroke}\" stroke-width=\"1.8\" stroke-dasharray=\"{dash}\"/>",
            points.join(" ")
        ));
    }

    pub(crate) fn dot(&mut self, (x, y): (f64, f64), r: f64, fill: &str, opacity: f64) {
        self.put(format_args!(
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{r:.1}\" fill=\"{fill}\" fill-opacity=\"{opacity}\"/>"
        ));
    }

    pub(crate) fn text(&mut self, at: (f64, f64), anchor: Anchor, fill: &str, text: &str) {
        self.turned(at, 0.0, anchor, fill, text);
    }

    /// Text turned by degrees, clockwise.
    pub(crate) fn turned(
        &mut self,
        (x, y): (f64, f64),
        degrees: f64,
        anchor: Anchor,
        fill: &str,
        text: &str,
    ) {
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let turn = if degrees == 0.0 {
            String::new()
        } else {
            format!(" transform=\"rotate({degrees} {x:.1} {y:.1})\"")
        };
        self.put(format_args!(
            "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" fill=\"{fill}\"{turn}>{}</text>",
            escape(text)
        ));
    }

    pub(crate) fn finish(self) -> String {
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\" role=\"img\" aria-label=\"{2}\" font-size=\"11\"><title>{2}</title>{3}</svg>",
            self.width, self.height, self.title, self.body
        )
    }

    fn put(&mut self, part: std::fmt::Arguments<'_>) {
        // Writing into a string cannot fail.
        let _ = self.body.write_fmt(part);
    }
}

/// Text that may stand in HTML and in its attributes.
pub(crate) fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

/// From white to full colour, for a share of a cell.
pub(crate) fn shade(full: [u8; 3], share: f64) -> String {
    let mix = |channel: u8| 255.0 + (f64::from(channel) - 255.0) * share.clamp(0.0, 1.0);
    let [r, g, b] = full.map(mix);
    format!("rgb({r:.0},{g:.0},{b:.0})")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hostile_text_stays_text() {
        let mut svg = Svg::new(10.0, 10.0, "\"<x>");
        svg.text((1.0, 2.0), Anchor::Start, INK, "<script>&");
        let text = svg.finish();
        assert!(text.contains("&lt;script&gt;&amp;"));
        assert!(text.contains("aria-label=\"&quot;&lt;x&gt;\""));
    }

    #[test]
    fn a_shade_goes_from_white_to_the_colour() {
        assert_eq!(shade([0, 100, 200], 0.0), "rgb(255,255,255)");
        assert_eq!(shade([0, 100, 200], 1.0), "rgb(0,100,200)");
        assert_eq!(shade([0, 100, 200], 7.0), "rgb(0,100,200)");
    }
}
