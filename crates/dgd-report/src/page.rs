//! One self-contained HTML page: text, tables, formulas and figures, for the screen and for A4.

use std::fmt::Write as _;

use crate::error::ReportError;
use crate::figure::Figure;
use crate::font;
use crate::formula;
use crate::xml::escape;

const STYLE: &str = include_str!("page.css");

/// A table of texts.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Table {
    /// Words above the table; may be empty.
    pub caption: String,
    /// Column heads.
    pub head: Vec<String>,
    /// Rows; a short row is filled up with empty cells, a long one makes the table wider.
    pub rows: Vec<Vec<String>>,
}

/// An HTML page that is built from top to bottom and needs nothing but itself: no network, no script.
///
/// The font of the figures is inside (0.1 MB). All text is escaped. The result is well-formed XML, too.
///
/// ```
/// use dgd_report::{Axis, Page, Scatter, all_samples};
///
/// let flow = [0.0, 50.0, 100.0];
/// let friction = [0.0, 22.0, 81.0];
/// let figure = all_samples(
///     Scatter { x: &flow, y: &friction },
///     &Axis::new("Return flow [%]"),
///     &Axis::new("Frictional pressure loss [%]"),
/// )?;
/// let mut page = Page::new("Identification", "Friction < 100 % in all samples.");
/// page.section("Friction").paragraph("What was measured.").figure(&figure);
/// page.formula("<math><mi>F</mi><mo>=</mo><mi>D</mi><msup><mi>q</mi><mn>2</mn></msup></math>")?;
/// assert!(page.html().contains("Friction &lt; 100 %"));
/// # Ok::<(), dgd_report::ReportError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Page {
    title: String,
    lead: String,
    sections: Vec<String>,
    body: String,
    style: &'static str,
}

impl Page {
    /// A page with its title and the one sentence that says what was found.
    pub fn new(title: impl Into<String>, lead: impl Into<String>) -> Self {
        Self {
            title: title.into(),
            lead: lead.into(),
            sections: Vec::new(),
            body: String::new(),
            style: "",
        }
    }

    /// Further CSS of ours, after the page's own.
    pub(crate) fn styled(mut self, style: &'static str) -> Self {
        self.style = style;
        self
    }

    /// HTML of ours, in which all text is escaped already.
    pub(crate) fn raw(&mut self, html: &str) -> &mut Self {
        self.body.push_str(html);
        self
    }

    /// Starts a section; what follows belongs to it.
    pub fn section(&mut self, heading: &str) -> &mut Self {
        if !self.sections.is_empty() {
            self.body.push_str("</section>\n");
        }
        self.sections.push(heading.to_owned());
        let number = self.sections.len();
        self.add(format_args!(
            "<section id=\"s{number}\">\n<h2>{}</h2>\n",
            escape(heading)
        ))
    }

    /// A heading within a section.
    pub fn subsection(&mut self, heading: &str) -> &mut Self {
        self.add(format_args!("<h3>{}</h3>\n", escape(heading)))
    }

    /// A paragraph.
    pub fn paragraph(&mut self, text: &str) -> &mut Self {
        self.add(format_args!("<p>{}</p>\n", escape(text)))
    }

    /// A paragraph that must not be overlooked, such as a limit of the result.
    pub fn note(&mut self, text: &str) -> &mut Self {
        self.add(format_args!("<p class=\"note\">{}</p>\n", escape(text)))
    }

    /// A list of points.
    pub fn list<S: AsRef<str>>(&mut self, items: &[S]) -> &mut Self {
        if items.is_empty() {
            return self;
        }
        self.body.push_str("<ul>\n");
        for item in items {
            self.add(format_args!("<li>{}</li>\n", escape(item.as_ref())));
        }
        self.body.push_str("</ul>\n");
        self
    }

    /// A table. Columns that hold only numbers are set to the right.
    pub fn table(&mut self, table: &Table) -> &mut Self {
        let columns = table
            .rows
            .iter()
            .map(Vec::len)
            .chain([table.head.len()])
            .max()
            .unwrap_or(0);
        if columns == 0 {
            return self;
        }
        let cell = |row: &[String], column: usize| {
            row.get(column)
                .map_or_else(String::new, |text| escape(text))
        };
        let class: Vec<&str> = (0..columns)
            .map(|column| {
                if is_numeric(&table.rows, column) {
                    " class=\"n\""
                } else {
                    ""
                }
            })
            .collect();
        self.body.push_str("<table>\n");
        if !table.caption.is_empty() {
            self.add(format_args!(
                "<caption>{}</caption>\n",
                escape(&table.caption)
            ));
        }
        if !table.head.is_empty() {
            self.body.push_str("<thead><tr>");
            for (column, class) in class.iter().enumerate() {
                self.add(format_args!(
                    "<th scope=\"col\"{class}>{}</th>",
                    cell(&table.head, column)
                ));
            }
            self.body.push_str("</tr></thead>\n");
        }
        self.body.push_str("<tbody>\n");
        for row in &table.rows {
            self.body.push_str("<tr>");
            for (column, class) in class.iter().enumerate() {
                self.add(format_args!("<td{class}>{}</td>", cell(row, column)));
            }
            self.body.push_str("</tr>\n");
        }
        self.body.push_str("</tbody>\n</table>\n");
        self
    }

    /// A figure as inline SVG with its number and caption.
    pub fn figure(&mut self, figure: &Figure) -> &mut Self {
        let heading = figure.heading();
        let heading = if heading.is_empty() {
            heading
        } else {
            format!("<b>{}</b> ", escape(&heading))
        };
        self.add(format_args!(
            "<figure>\n{}<figcaption>{heading}{}</figcaption>\n</figure>\n",
            figure.svg(),
            escape(figure.caption()),
        ))
    }

    /// A formula on a line of its own, as a presentation MathML `math` element.
    ///
    /// # Errors
    /// [`ReportError::Formula`] with the byte where it stops being plain, balanced MathML: unknown elements, event
    /// handlers, links, comments and bare `&` or `<` are refused.
    pub fn formula(&mut self, mathml: &str) -> Result<&mut Self, ReportError> {
        formula::check(mathml)?;
        Ok(self.add(format_args!("<div class=\"formula\">{mathml}</div>\n")))
    }

    /// The finished page.
    #[must_use]
    pub fn html(&self) -> String {
        let title = escape(&self.title);
        let mut out = format!(
            "<!DOCTYPE html>\n<html lang=\"en\" xmlns=\"http://www.w3.org/1999/xhtml\">\n<head>\n\
             <meta charset=\"utf-8\"/>\n<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
             <title>{title}</title>\n<style>\n{}{STYLE}{}</style>\n</head>\n<body>\n<main>\n<header>\n<h1>{title}</h1>\n",
            font::css(),
            self.style,
        );
        if !self.lead.is_empty() {
            push(
                &mut out,
                format_args!("<p class=\"lead\">{}</p>\n", escape(&self.lead)),
            );
        }
        out.push_str("</header>\n");
        if self.sections.len() > 2 {
            out.push_str("<nav><ol>\n");
            for (index, heading) in self.sections.iter().enumerate() {
                push(
                    &mut out,
                    format_args!(
                        "<li><a href=\"#s{}\">{}</a></li>\n",
                        index + 1,
                        escape(heading)
                    ),
                );
            }
            out.push_str("</ol></nav>\n");
        }
        out.push_str(&self.body);
        if !self.sections.is_empty() {
            out.push_str("</section>\n");
        }
        out.push_str("</main>\n</body>\n</html>\n");
        out
    }

    fn add(&mut self, text: std::fmt::Arguments<'_>) -> &mut Self {
        push(&mut self.body, text);
        self
    }
}

fn push(out: &mut String, text: std::fmt::Arguments<'_>) {
    // Writing to a String cannot fail.
    let _ = out.write_fmt(text);
}

/// Numbers, perhaps with a sign, a unit sign or a dash for "none"; at least one real number.
fn is_numeric(rows: &[Vec<String>], column: usize) -> bool {
    let mut some = false;
    for text in rows
        .iter()
        .filter_map(|row| row.get(column))
        .map(|text| text.trim())
    {
        let first = text
            .trim_start_matches(['−', '-', '+', '±', '<', '>', ' '])
            .chars()
            .next();
        match first {
            Some(c) if c.is_ascii_digit() => some = true,
            None => {}
            Some('–' | '—') => {}
            Some(_) => return false,
        }
    }
    some
}
