//! HTML that cannot forget to escape: text goes in as text, tags by name.

use std::fmt::Write as _;

use crate::scene::Scene;
use crate::svg;
use crate::xml::escape;

/// A piece of the page.
#[derive(Debug, Default)]
pub(super) struct Html(String);

/// A cell of a table.
#[derive(Debug, Clone)]
pub(super) enum Cell {
    Text(String),
    /// Set to the right, not broken.
    Number(String),
    /// Text, and below it a name for machines in small type.
    Named(String, String),
    /// A share from 0 to 1 as a bar with its number.
    Bar(f64, String, bool),
    /// A word in the colour of its class.
    Mark(&'static str, String),
}

impl Html {
    pub(super) fn text(&self) -> &str {
        &self.0
    }

    fn add(&mut self, text: std::fmt::Arguments<'_>) -> &mut Self {
        // Writing to a String cannot fail.
        let _ = self.0.write_fmt(text);
        self
    }

    pub(super) fn open(&mut self, tag: &str, class: &str) -> &mut Self {
        self.add(format_args!("<{tag} class=\"{class}\">\n"))
    }

    pub(super) fn close(&mut self, tag: &str) -> &mut Self {
        self.add(format_args!("</{tag}>\n"))
    }

    /// `<tag class>text</tag>`.
    pub(super) fn element(&mut self, tag: &str, class: &str, text: &str) -> &mut Self {
        self.add(format_args!(
            "<{tag} class=\"{class}\">{}</{tag}>\n",
            escape(text)
        ))
    }

    pub(super) fn heading(&mut self, text: &str) -> &mut Self {
        self.add(format_args!("<h3>{}</h3>\n", escape(text)))
    }

    pub(super) fn paragraph(&mut self, text: &str) -> &mut Self {
        self.add(format_args!("<p>{}</p>\n", escape(text)))
    }

    pub(super) fn note(&mut self, text: &str) -> &mut Self {
        self.element("p", "note", text)
    }

    pub(super) fn small(&mut self, text: &str) -> &mut Self {
        self.element("p", "small", text)
    }

    /// A bold word and a sentence.
    pub(super) fn labelled(&mut self, label: &str, text: &str) -> &mut Self {
        self.add(format_args!(
            "<p><b>{}</b> {}</p>\n",
            escape(label),
            escape(text)
        ))
    }

    pub(super) fn code_block(&mut self, text: &str) -> &mut Self {
        self.add(format_args!("<pre><code>{}</code></pre>\n", escape(text)))
    }

    /// MathML that our own writer made.
    pub(super) fn mathml(&mut self, mathml: &str) -> &mut Self {
        self.0.push_str(mathml);
        self
    }

    /// A name and its value in a strip of such pairs.
    pub(super) fn fact(&mut self, name: &str, value: &str, more: &str) -> &mut Self {
        self.add(format_args!(
            "<div><dt>{}</dt><dd>{}",
            escape(name),
            escape(value)
        ));
        if !more.is_empty() {
            self.add(format_args!("<small>{}</small>", escape(more)));
        }
        self.add(format_args!("</dd></div>\n"))
    }

    /// A picture with the words that stand in for it, and its caption.
    pub(super) fn picture(&mut self, scene: &Scene, title: &str, caption: &str) -> &mut Self {
        self.add(format_args!(
            "<figure>\n{}<figcaption><b>{}.</b> {}</figcaption>\n</figure>\n",
            svg::write(scene, title, caption),
            escape(title),
            escape(caption)
        ))
    }

    /// A table whose first column names its rows. A column is set to the right where its first row is.
    pub(super) fn table(
        &mut self,
        caption: &str,
        head: &[&str],
        rows: &[Vec<Cell>],
        class: &str,
    ) -> &mut Self {
        self.add(format_args!(
            "<table class=\"{class}\">\n<caption>{}</caption>\n<thead><tr>",
            escape(caption)
        ));
        for (column, name) in head.iter().enumerate() {
            let right = matches!(
                rows.first().and_then(|r| r.get(column)),
                Some(Cell::Number(_))
            );
            let class = if right { " class=\"n\"" } else { "" };
            self.add(format_args!(
                "<th scope=\"col\"{class}>{}</th>",
                escape(name)
            ));
        }
        self.add(format_args!("</tr></thead>\n<tbody>\n"));
        for row in rows {
            self.add(format_args!("<tr>"));
            for (column, cell) in row.iter().enumerate() {
                self.cell(cell, column == 0);
            }
            self.add(format_args!("</tr>\n"));
        }
        self.add(format_args!("</tbody>\n</table>\n"))
    }

    fn cell(&mut self, cell: &Cell, names_row: bool) {
        let (tag, scope) = if names_row {
            ("th", " scope=\"row\"")
        } else {
            ("td", "")
        };
        let class = if matches!(cell, Cell::Number(_)) {
            " class=\"n\""
        } else {
            ""
        };
        self.add(format_args!("<{tag}{scope}{class}>"));
        match cell {
            Cell::Text(text) | Cell::Number(text) => self.add(format_args!("{}", escape(text))),
            Cell::Named(text, name) => self.add(format_args!(
                "{} <code class=\"name\">{}</code>",
                escape(text),
                // A long name may break where its words meet.
                escape(name).replace('_', "_<wbr/>")
            )),
            Cell::Bar(share, text, first) => {
                let share = if share.is_finite() {
                    share.clamp(0.0, 1.0)
                } else {
                    0.0
                };
                self.add(format_args!(
                    "<span class=\"bar\"><i class=\"{}\" style=\"width:{:.1}%\"></i></span><span class=\"share\">{}</span>",
                    if *first { "first" } else { "other" },
                    100.0 * share,
                    escape(text)
                ))
            }
            Cell::Mark(class, text) => self.add(format_args!(
                "<span class=\"mark {class}\">{}</span>",
                escape(text)
            )),
        };
        self.add(format_args!("</{tag}>"));
    }
}
