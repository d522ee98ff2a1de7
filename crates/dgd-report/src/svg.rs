//! A scene as SVG text: no ids, no scripts, no references, so that many can stand in one page.

use std::fmt::Write as _;

use crate::color::Color;
use crate::font::FAMILY;
use crate::scene::{Anchor, Pen, Runs, Scene, Shape};
use crate::xml::escape;

pub(crate) fn write(scene: &Scene, title: &str, description: &str) -> String {
    let mut out = String::with_capacity(16 * 1024);
    let (w, h) = (number(scene.width), number(scene.height));
    push(
        &mut out,
        format_args!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{w}\" height=\"{h}\" viewBox=\"0 0 {w} {h}\" role=\"img\" \
             font-family=\"{FAMILY}\">\n<title>{}</title>\n<desc>{}</desc>\n\
             <rect width=\"{w}\" height=\"{h}\" fill=\"#ffffff\"/>\n",
            escape(title),
            escape(description),
        ),
    );
    for shape in &scene.shapes {
        write_shape(&mut out, shape);
    }
    out.push_str("</svg>\n");
    out
}

fn push(out: &mut String, text: std::fmt::Arguments<'_>) {
    // Writing to a String cannot fail.
    let _ = out.write_fmt(text);
}

/// Two decimals, no trailing zeros, no minus zero: a hundredth of a unit is far below a printer's dot.
fn number(value: f64) -> String {
    let text = format!("{value:.2}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" {
        "0".to_owned()
    } else {
        text.to_owned()
    }
}

fn color(c: Color) -> String {
    format!("#{:02x}{:02x}{:02x}", c.0, c.1, c.2)
}

fn pen_attributes(pen: &Pen) -> String {
    let mut text = format!(
        "stroke=\"{}\" stroke-width=\"{}\"",
        color(pen.color),
        number(pen.width)
    );
    if let Some([on, off]) = pen.dash {
        push(
            &mut text,
            format_args!(" stroke-dasharray=\"{} {}\"", number(on), number(off)),
        );
    }
    text
}

fn write_shape(out: &mut String, shape: &Shape) {
    match shape {
        Shape::Rect { at, size, fill } => push(
            out,
            format_args!(
                "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"{}\"/>\n",
                number(at[0]),
                number(at[1]),
                number(size[0]),
                number(size[1]),
                color(*fill),
            ),
        ),
        Shape::Lines { lines, pen } => {
            out.push_str("<path d=\"");
            for line in lines {
                write_points(out, line);
            }
            push(
                out,
                format_args!(
                    "\" fill=\"none\" {} stroke-linejoin=\"round\"/>\n",
                    pen_attributes(pen)
                ),
            );
        }
        Shape::Polygon {
            points,
            fill,
            opacity,
        } => {
            out.push_str("<path d=\"");
            write_points(out, points);
            push(out, format_args!("Z\" fill=\"{}\"", color(*fill)));
            if *opacity < 1.0 {
                push(out, format_args!(" fill-opacity=\"{}\"", number(*opacity)));
            }
            out.push_str("/>\n");
        }
        Shape::Circle {
            centre,
            radius,
            fill,
            pen,
        } => {
            push(
                out,
                format_args!(
                    "<circle cx=\"{}\" cy=\"{}\" r=\"{}\" fill=\"{}\"",
                    number(centre[0]),
                    number(centre[1]),
                    number(*radius),
                    fill.map_or_else(|| "none".to_owned(), color),
                ),
            );
            if let Some(pen) = pen {
                push(out, format_args!(" {}", pen_attributes(pen)));
            }
            out.push_str("/>\n");
        }
        Shape::Dots {
            runs,
            width,
            color: c,
        } => write_runs(out, runs, *width, *c),
        Shape::Text {
            at,
            text,
            size,
            bold,
            color: c,
            anchor,
            upright,
        } => {
            let (x, y) = (number(at[0]), number(at[1]));
            push(
                out,
                format_args!(
                    "<text x=\"{x}\" y=\"{y}\" font-size=\"{}\" fill=\"{}\"",
                    number(*size),
                    color(*c)
                ),
            );
            match anchor {
                Anchor::Start => {}
                Anchor::Middle => out.push_str(" text-anchor=\"middle\""),
                Anchor::End => out.push_str(" text-anchor=\"end\""),
            }
            if *bold {
                out.push_str(" font-weight=\"bold\"");
            }
            if *upright {
                push(out, format_args!(" transform=\"rotate(-90 {x} {y})\""));
            }
            push(out, format_args!(">{}</text>\n", escape(text)));
        }
    }
}

fn write_points(out: &mut String, points: &[[f64; 2]]) {
    for (index, [x, y]) in points.iter().enumerate() {
        let command = match index {
            0 => "M",
            1 => "L",
            _ => " ",
        };
        push(out, format_args!("{command}{} {}", number(*x), number(*y)));
    }
}

/// In cell units and relative steps: five characters a run instead of fifteen.
fn write_runs(out: &mut String, runs: &Runs, width: f64, c: Color) {
    if runs.runs.is_empty() {
        return;
    }
    push(
        out,
        format_args!(
            "<path transform=\"translate({} {}) scale({})\" d=\"",
            number(runs.origin[0]),
            number(runs.origin[1]),
            number(runs.cell)
        ),
    );
    let (mut x, mut y) = (0_i64, 0_i64);
    for (index, run) in runs.runs.iter().enumerate() {
        let [row, first, last] = run.map(i64::from);
        push(
            out,
            format_args!(
                "{}{} {}h{}",
                if index == 0 { 'M' } else { 'm' },
                first - x,
                row - y,
                last - first
            ),
        );
        (x, y) = (last, row);
    }
    push(
        out,
        format_args!(
            "\" fill=\"none\" stroke=\"{}\" stroke-width=\"{}\" stroke-linecap=\"round\"/>\n",
            color(c),
            number(width / runs.cell)
        ),
    );
}

#[cfg(test)]
mod tests {
    use super::number;

    #[test]
    fn numbers_are_short_and_without_minus_zero() {
        assert_eq!(number(12.340_01), "12.34");
        assert_eq!(number(-0.001), "0");
        assert_eq!(number(100.0), "100");
    }
}
