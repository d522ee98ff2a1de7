use dgd_report::{Page, ReportError, Table};

use crate::figures;

const FORMULA: &str = "<math display=\"block\"><mi>F</mi><mo>=</mo><mi>D</mi><msup><mi>q</mi><mn>2</mn></msup></math>";

fn full() -> String {
    let mut page = Page::new("Report & <title>", "Friction < 100 % \"always\".");
    page.section("One <b>")
        .paragraph("A & B <script>alert(1)</script>\u{0}")
        .note("Mind 'this'.");
    page.list(&["<li>", "two"]).formula(FORMULA).unwrap();
    page.section("Two").table(&Table {
        caption: "A < B".to_owned(),
        head: vec!["Name".to_owned(), "Value & unit".to_owned()],
        rows: vec![
            vec!["</td>".to_owned(), "1.5".to_owned()],
            vec!["short".to_owned()],
        ],
    });
    page.section("Three");
    for (_, figure) in figures::all(3000) {
        page.figure(&figure);
    }
    page.html()
}

/// Our pages are XML, too; the parser wants to be told that a DOCTYPE is allowed.
fn parse(html: &str) -> roxmltree::Document<'_> {
    let options = roxmltree::ParsingOptions {
        allow_dtd: true,
        ..Default::default()
    };
    roxmltree::Document::parse_with_options(html, options).unwrap()
}

#[test]
fn a_page_with_everything_is_well_formed() {
    let html = full();
    let document = parse(&html);
    let count = |name: &str| {
        document
            .descendants()
            .filter(|n| n.tag_name().name() == name)
            .count()
    };
    assert_eq!(count("figure"), figures::all(3000).len());
    assert_eq!(
        (
            count("svg"),
            count("section"),
            count("table"),
            count("math")
        ),
        (count("figure"), 3, 1, 1)
    );
}

#[test]
fn text_is_escaped_everywhere() {
    let html = full();
    let document = parse(&html);
    let texts: Vec<&str> = document.descendants().filter_map(|n| n.text()).collect();
    for wanted in [
        "Report & <title>",
        "Friction < 100 % \"always\".",
        "One <b>",
        "A & B <script>alert(1)</script>",
        "Mind 'this'.",
        "<li>",
        "A < B",
        "Value & unit",
        "</td>",
    ] {
        assert!(texts.contains(&wanted), "{wanted}");
    }
}

#[test]
fn a_page_needs_no_network_and_runs_nothing() {
    let html = full();
    let document = parse(&html);
    for node in document.descendants().filter(roxmltree::Node::is_element) {
        assert!(!matches!(
            node.tag_name().name(),
            "script" | "link" | "img" | "iframe" | "object" | "form"
        ));
        for attribute in node.attributes() {
            assert!(!attribute.name().starts_with("on") && attribute.name() != "src");
            assert!(attribute.name() != "href" || attribute.value().starts_with("#s"));
        }
    }
    let style = document
        .descendants()
        .find(|n| n.tag_name().name() == "style")
        .unwrap()
        .text()
        .unwrap();
    assert!(!style.contains("@import"));
    assert_eq!(
        style.matches("url(").count(),
        style.matches("url(data:font/ttf;base64,").count()
    );
    assert!(style.contains("@page") && style.contains("size: A4"));
}

#[test]
fn short_rows_are_filled_and_numbers_set_right() {
    let mut page = Page::new("t", "");
    page.table(&Table {
        rows: vec![
            vec!["a".to_owned(), "−1.5".to_owned()],
            vec!["b".to_owned()],
        ],
        ..Table::default()
    });
    let html = page.html();
    assert!(
        html.contains("<td>a</td><td class=\"n\">−1.5</td>")
            && html.contains("<td>b</td><td class=\"n\"></td>")
    );
}

#[test]
fn the_same_page_gives_the_same_bytes() {
    assert_eq!(full(), full());
}

#[test]
fn an_empty_page_is_still_a_page() {
    let html = Page::new("", "").html();
    assert!(
        parse(&html)
            .descendants()
            .any(|n| n.tag_name().name() == "h1")
    );
}

#[test]
fn plain_mathml_is_accepted() {
    for formula in [
        FORMULA,
        "<math xmlns=\"http://www.w3.org/1998/Math/MathML\"><mfrac><mn>1</mn><mn>2</mn></mfrac></math>",
        " <math><mo>&lt;</mo><mo>&#x2212;</mo><mspace width=\"1em\"/></math>\n",
    ] {
        let mut page = Page::new("t", "");
        page.formula(formula).unwrap();
        parse(&page.html());
    }
}

#[test]
fn anything_but_plain_mathml_is_refused() {
    for formula in [
        "",
        "text",
        "<math>",
        "<math></math><math></math>",
        "<math></mrow></math>",
        "<math><mi>a</math></mi>",
        "<mi>a</mi>",
        "<math><script>alert(1)</script></math>",
        "<math><annotation-xml><b/></annotation-xml></math>",
        "<math onclick=\"alert(1)\"></math>",
        "<math href=\"x\"></math>",
        "<math><mi style=\"color:red\">a</mi></math>",
        "<math xmlns=\"other\"></math>",
        "<math display=\"block\" display=\"block\"></math>",
        "<math display=block></math>",
        "<math display=\"block\"width=\"1\"></math>",
        "<math><mi>a & b</mi></math>",
        "<math><mi>&nbsp;</mi></math>",
        "<math><mi>&#0;</mi></math>",
        "<math><mi>&#x+41;</mi></math>",
        "<math><mi>\u{0}</mi></math>",
        "<math><!-- --></math>",
        "<math></math> after",
        "<math",
    ] {
        let refused = Page::new("t", "").formula(formula).map(|_| ()).unwrap_err();
        assert!(matches!(refused, ReportError::Formula { .. }), "{formula}");
    }
}

#[test]
fn a_formula_nested_without_end_is_refused() {
    let deep = format!(
        "<math>{}{}</math>",
        "<mrow>".repeat(100_000),
        "</mrow>".repeat(100_000)
    );
    assert!(Page::new("t", "").formula(&deep).is_err());
}
