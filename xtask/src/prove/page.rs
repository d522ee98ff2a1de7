//! What every page of the pipeline shares: self-contained, readable on paper.

use super::svg::escape;
use std::fmt::Write;

const STYLE: &str = "
:root{color-scheme:light}
body{font:15px/1.5 system-ui,-apple-system,'Segoe UI',Roboto,'Helvetica Neue',Arial,sans-serif;color:#1c2733;max-width:980px;margin:2.5rem auto;padding:0 1.2rem}
h1{font-size:1.9rem;line-height:1.2;margin:0 0 .4rem}
h2{font-size:1.25rem;margin:2.6rem 0 .5rem;padding-top:.7rem;border-top:1px solid #dfe5ea}
h3{font-size:1rem;margin:1.5rem 0 .3rem}
p{max-width:46rem}
.lead{font-size:1.1rem}
.quiet{color:#5b6875;font-size:.88rem}
table{border-collapse:collapse;font-size:.86rem;margin:.6rem 0;font-variant-numeric:tabular-nums}
th,td{text-align:left;padding:.2rem .7rem .2rem 0;border-bottom:1px solid #e8edf1;vertical-align:top}
thead th{border-bottom:1.5px solid #8794a1;font-weight:600}
tbody th{font-weight:400}
td.n{text-align:right;font-weight:600;white-space:nowrap}
td.b{color:#5b6875;white-space:nowrap}
.met{color:#2f7d5b;white-space:nowrap}.missed{color:#b8442a;white-space:nowrap}
figure{margin:1rem 0;overflow-x:auto}
figcaption{color:#5b6875;font-size:.88rem;max-width:46rem;margin-top:.3rem}
svg{max-width:100%;height:auto;font-family:inherit}
code{font:.84em ui-monospace,SFMono-Regular,Menlo,Consolas,monospace;overflow-wrap:anywhere}
.case{margin:.9rem 0;break-inside:avoid;font-size:.88rem}
.case p{margin:.1rem 0;max-width:none}
@media(max-width:860px){table{font-size:.74rem}th,td{padding-right:.4rem}}
@media print{body{margin:0;padding:0;max-width:none;font-size:10pt}table{font-size:7.5pt}th,td{padding-right:.4rem}h2,h3{break-after:avoid}figure,tr{break-inside:avoid}@page{margin:16mm 14mm}}
";

/// Adds a line to a page; writing into a string cannot fail.
macro_rules! put {
    ($html:expr, $($arg:tt)*) => {{
        use std::fmt::Write as _;
        let _ = writeln!($html, $($arg)*);
    }};
}
pub(crate) use put;

/// A page up to its body.
pub(crate) fn begin(title: &str) -> String {
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width\">\
         <title>{}</title><style>{STYLE}</style></head><body>\n",
        escape(title)
    )
}

/// What closes a page that [`begin`] opened.
pub(crate) const END: &str = "</body></html>\n";

/// A section that is a picture with its caption; the caption is HTML.
pub(crate) fn figure(html: &mut String, title: &str, svg: &str, caption: &str) {
    put!(html, "<h2>{}</h2>", escape(title));
    picture(html, svg, caption);
}

/// A picture within a section; the caption is HTML.
pub(crate) fn picture(html: &mut String, svg: &str, caption: &str) {
    put!(
        html,
        "<figure>{svg}<figcaption>{caption}</figcaption></figure>"
    );
}

/// A cell of a table; what it holds is text, not HTML.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Cell {
    /// Heads its row.
    Name(String),
    Text(String),
    /// To the right, in bold.
    Number(String),
    /// In small grey: what stands behind the number before it.
    Basis(String),
    /// Beside a target: met, missed, or undecided.
    Target(Option<bool>, String),
}

/// A table; a row may be shorter than the head.
pub(crate) fn table(html: &mut String, head: &[&str], rows: &[Vec<Cell>]) {
    html.push_str("<table><thead><tr>");
    for title in head {
        let _ = write!(html, "<th scope=\"col\">{}</th>", escape(title));
    }
    html.push_str("</tr></thead><tbody>\n");
    for row in rows {
        html.push_str("<tr>");
        row.iter().for_each(|c| html.push_str(&cell(c)));
        html.push_str("</tr>\n");
    }
    html.push_str("</tbody></table>\n");
}

fn cell(cell: &Cell) -> String {
    match cell {
        Cell::Name(text) => format!("<th scope=\"row\">{}</th>", escape(text)),
        Cell::Text(text) => format!("<td>{}</td>", escape(text)),
        Cell::Number(text) => format!("<td class=\"n\">{}</td>", escape(text)),
        Cell::Basis(text) => format!("<td class=\"b\">{}</td>", escape(text)),
        Cell::Target(met, text) => {
            let text = escape(text);
            match met {
                Some(true) => format!("<td><span class=\"met\">✓ {text}</span></td>"),
                Some(false) => format!("<td><span class=\"missed\">✗ {text}</span></td>"),
                None => format!("<td>{text}</td>"),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_is_closed_and_what_tables_hold_stays_text() {
        let mut html = begin("a < b");
        table(
            &mut html,
            &["<x>"],
            &[vec![
                Cell::Name("&".into()),
                Cell::Target(Some(false), "<b>".into()),
            ]],
        );
        html.push_str(END);
        assert!(html.contains("<title>a &lt; b</title>"));
        assert!(html.contains("<th scope=\"col\">&lt;x&gt;</th>"));
        assert!(html.contains("<th scope=\"row\">&amp;</th>"));
        assert!(html.contains("✗ &lt;b&gt;"));
        assert!(html.ends_with("</html>\n"));
        assert!(!html.contains("<script"), "nothing of it runs");
    }
}
