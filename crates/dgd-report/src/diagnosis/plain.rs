//! Equations in plain notation, `A dh/dt = q_in + v^2 / (2 d)`, as MathML; what cannot be read stays code.
//!
//! A slash without spaces divides its neighbours, a slash between spaces the whole product on its left; factors stand
//! side by side. `dh/dt` is a derivative, `dp` alone a difference. Words of three letters and more stand upright.

use super::symbol::{is_word, symbol};
use super::token::{Token, What, tokens};
use crate::formula;
use crate::xml::escape;

const LONGEST: usize = 400;
const DEEPEST: usize = 16;

/// The equation as a `math` element, or as `code` if it is no plain notation.
pub(super) fn formula(text: &str) -> String {
    let text = text.trim();
    mathml(text)
        .filter(|m| formula::check(m).is_ok())
        .unwrap_or_else(|| format!("<code>{}</code>", escape(text)))
}

fn mathml(text: &str) -> Option<String> {
    if text.is_empty() || text.len() > LONGEST {
        return None;
    }
    let tokens = tokens(text)?;
    let mut parser = Parser {
        tokens: &tokens,
        at: 0,
        depth: 0,
        bars: 0,
    };
    let inner = parser.list()?;
    (parser.at == tokens.len()).then(|| {
        format!(
            "<math displaystyle=\"true\" alttext=\"{}\"><mrow>{inner}</mrow></math>",
            escape(text)
        )
    })
}

struct Parser<'a> {
    tokens: &'a [Token],
    at: usize,
    depth: usize,
    bars: usize,
}

/// A factor, and what decides the space beside it.
struct Factor {
    mathml: String,
    /// Without the brackets that a fraction makes needless.
    bare: Option<String>,
    word: bool,
}

impl Parser<'_> {
    fn sign(&self) -> Option<&'static str> {
        match self.tokens.get(self.at)?.what {
            What::Sign(sign) => Some(sign),
            _ => None,
        }
    }

    fn takes(&mut self, sign: &str) -> bool {
        let found = self.sign() == Some(sign);
        self.at += usize::from(found);
        found
    }

    /// Sums with relations, commas and semicolons between them.
    fn list(&mut self) -> Option<String> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return None;
        }
        let mut out = self.sum()?;
        while let Some(sign) = self.sign() {
            match sign {
                "=" | "<" | ">" | "≤" | "≥" | "≈" | "→" => out.push_str(&operator(sign)),
                "," | ";" | ":" => {
                    out.push_str(&operator(sign));
                    // Between statements, not between arguments.
                    if self.depth == 1 {
                        out.push_str("<mspace width=\"0.5em\"/>");
                    }
                }
                _ => break,
            }
            self.at += 1;
            out.push_str(&self.sum()?);
        }
        self.depth -= 1;
        Some(out)
    }

    fn sum(&mut self) -> Option<String> {
        let mut out = String::new();
        if let Some(sign @ ("−" | "+" | "±")) = self.sign() {
            out.push_str(&format!("<mo form=\"prefix\">{sign}</mo>"));
            self.at += 1;
        }
        out.push_str(&self.product()?);
        while let Some(sign @ ("+" | "−" | "±")) = self.sign() {
            self.at += 1;
            out.push_str(&operator(sign));
            out.push_str(&self.product()?);
        }
        Some(out)
    }

    fn product(&mut self) -> Option<String> {
        let mut factors = vec![self.factor()?];
        loop {
            match self.sign() {
                Some(dot @ ("·" | "×")) => {
                    self.at += 1;
                    factors.push(Factor {
                        mathml: operator(dot),
                        bare: None,
                        word: false,
                    });
                    factors.push(self.factor()?);
                }
                Some("/") => {
                    self.at += 1;
                    let below = self.factor()?;
                    let above = match factors.as_mut_slice() {
                        [one] => one.bare.take().unwrap_or_else(|| one.mathml.clone()),
                        many => side_by_side(many),
                    };
                    factors = vec![fraction(&above, &below)];
                }
                Some("(" | "[") => factors.push(self.factor()?),
                Some("|") if self.bars == 0 => factors.push(self.factor()?),
                Some(_) => break,
                None if self.at < self.tokens.len() => factors.push(self.factor()?),
                None => break,
            }
        }
        Some(side_by_side(&factors))
    }

    /// A power, over another where a slash stands without spaces.
    fn factor(&mut self) -> Option<Factor> {
        let mut left = match self.derivative() {
            Some(derivative) => derivative,
            None => self.power()?,
        };
        while self.sign() == Some("/")
            && !self.tokens[self.at].apart
            && self.tokens.get(self.at + 1).is_some_and(|t| !t.apart)
        {
            self.at += 1;
            let right = self.power()?;
            let above = left.bare.take().unwrap_or(left.mathml);
            left = fraction(&above, &right);
        }
        Some(left)
    }

    /// `dh/dt` or `d(rho)/dt`.
    fn derivative(&mut self) -> Option<Factor> {
        let start = self.at;
        let found = self.try_derivative();
        if found.is_none() {
            self.at = start;
        }
        found
    }

    fn try_derivative(&mut self) -> Option<Factor> {
        let What::Name(name) = &self.tokens.get(self.at)?.what else {
            return None;
        };
        let of = name.strip_prefix('d')?;
        self.at += 1;
        let above = if of.is_empty() {
            let group = self.atom()?;
            group.bare?
        } else {
            symbol(of)
        };
        if !self.takes("/") {
            return None;
        }
        let What::Name(by) = &self.tokens.get(self.at)?.what else {
            return None;
        };
        let by = by.strip_prefix('d').filter(|by| !by.is_empty())?;
        self.at += 1;
        let d = "<mi mathvariant=\"normal\">d</mi>";
        Some(Factor {
            mathml: format!(
                "<mfrac><mrow>{d}{above}</mrow><mrow>{d}{}</mrow></mfrac>",
                symbol(by)
            ),
            bare: None,
            word: false,
        })
    }

    fn power(&mut self) -> Option<Factor> {
        let base = self.atom()?;
        if !self.takes("^") {
            return Some(base);
        }
        let negative = self.takes("−");
        let exponent = self.atom()?;
        let exponent = exponent.bare.unwrap_or(exponent.mathml);
        let sign = if negative {
            "<mo form=\"prefix\">−</mo>"
        } else {
            ""
        };
        Some(Factor {
            mathml: format!(
                "<msup><mrow>{}</mrow><mrow>{sign}{exponent}</mrow></msup>",
                base.mathml
            ),
            bare: None,
            word: false,
        })
    }

    fn atom(&mut self) -> Option<Factor> {
        let token = self.tokens.get(self.at)?;
        self.at += 1;
        match &token.what {
            What::Number(number) => Some(Factor {
                mathml: format!("<mn>{number}</mn>"),
                bare: None,
                word: false,
            }),
            What::Name(name) => self.name(name),
            What::Sign("|") => {
                self.bars += 1;
                let inner = self.sum()?;
                self.bars -= 1;
                self.takes("|").then(|| Factor {
                    mathml: format!(
                        "<mrow>{}{inner}{}</mrow>",
                        fence("|", "prefix"),
                        fence("|", "postfix")
                    ),
                    bare: None,
                    word: false,
                })
            }
            What::Sign(open @ ("(" | "[")) => {
                let bars = std::mem::take(&mut self.bars);
                let inner = self.list()?;
                self.bars = bars;
                let close = if *open == "(" { ")" } else { "]" };
                self.takes(close).then(|| Factor {
                    mathml: format!(
                        "<mrow>{}{inner}{}</mrow>",
                        fence(open, "prefix"),
                        fence(close, "postfix")
                    ),
                    bare: Some(inner),
                    word: false,
                })
            }
            What::Sign(_) => None,
        }
    }

    fn name(&mut self, name: &str) -> Option<Factor> {
        let called = self.sign() == Some("(") && !self.tokens[self.at].apart;
        if called && name == "sqrt" {
            let inner = self.atom()?.bare?;
            return Some(Factor {
                mathml: format!("<msqrt><mrow>{inner}</mrow></msqrt>"),
                bare: None,
                word: false,
            });
        }
        let mut mathml = symbol(name);
        if called {
            mathml = format!("<mrow>{mathml}{}</mrow>", self.atom()?.mathml);
        }
        Some(Factor {
            mathml,
            bare: None,
            word: !called && is_word(name),
        })
    }
}

fn operator(sign: &str) -> String {
    format!("<mo>{}</mo>", escape(sign))
}

fn fence(sign: &str, form: &str) -> String {
    format!("<mo form=\"{form}\" stretchy=\"true\" fence=\"true\">{sign}</mo>")
}

fn fraction(above: &str, below: &Factor) -> Factor {
    let below = below.bare.as_ref().unwrap_or(&below.mathml);
    Factor {
        mathml: format!("<mfrac><mrow>{above}</mrow><mrow>{below}</mrow></mfrac>"),
        bare: None,
        word: false,
    }
}

fn side_by_side(factors: &[Factor]) -> String {
    let mut out = String::new();
    for (index, factor) in factors.iter().enumerate() {
        let before = index.checked_sub(1).and_then(|i| factors.get(i));
        let signs = factor.mathml.starts_with("<mo>")
            || before.is_some_and(|b| b.mathml.starts_with("<mo>"));
        if let Some(before) = before
            && !signs
        {
            let words = before.word || factor.word;
            let width = if words { "0.3em" } else { "0.16em" };
            out.push_str(&format!("<mspace width=\"{width}\"/>"));
        }
        out.push_str(&factor.mathml);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn inner(text: &str) -> String {
        let all = formula(text);
        let start = all.find("<mrow>").map_or(0, |i| i + 6);
        all[start..].trim_end_matches("</mrow></math>").to_owned()
    }

    #[test]
    fn every_equation_of_the_catalogue_can_be_read() {
        for effect in dgd_effects::catalogue() {
            let about = effect.about();
            assert!(
                formula(about.equation).starts_with("<math"),
                "{}: {}",
                about.id,
                about.equation
            );
        }
    }

    #[test]
    fn a_tight_slash_divides_neighbours_and_a_spaced_one_the_product() {
        assert_eq!(
            inner("C V/T"),
            "<mi>C</mi><mspace width=\"0.16em\"/><mfrac><mrow><mi>V</mi></mrow><mrow><mi>T</mi></mrow></mfrac>"
        );
        assert_eq!(
            inner("a b / (2 d)"),
            "<mfrac><mrow><mi>a</mi><mspace width=\"0.16em\"/><mi>b</mi></mrow>\
             <mrow><mn>2</mn><mspace width=\"0.16em\"/><mi>d</mi></mrow></mfrac>"
        );
    }

    #[test]
    fn derivatives_and_differences_are_told_apart() {
        let d = "<mi mathvariant=\"normal\">d</mi>";
        assert_eq!(
            inner("dh/dt"),
            format!("<mfrac><mrow>{d}<mi>h</mi></mrow><mrow>{d}<mi>t</mi></mrow></mfrac>")
        );
        assert_eq!(
            inner("d(rho)/dt"),
            format!("<mfrac><mrow>{d}<mi>ρ</mi></mrow><mrow>{d}<mi>t</mi></mrow></mfrac>")
        );
        assert!(inner("dp").contains("Δ"));
    }

    #[test]
    fn subscripts_powers_and_greek_letters_are_set() {
        assert_eq!(
            inner("tau_y"),
            "<msub><mi>τ</mi><mrow><mi>y</mi></mrow></msub>"
        );
        assert_eq!(
            inner("q²"),
            "<msup><mrow><mi>q</mi></mrow><mrow><mn>2</mn></mrow></msup>"
        );
        assert_eq!(inner("q^2"), inner("q²"));
        assert!(inner("p_meter,i").contains("<mtext>meter</mtext>"));
        assert!(inner("k q |q|").contains("fence=\"true\">|</mo><mi>q</mi>"));
        assert!(inner("c1").starts_with("<msub>"));
    }

    #[test]
    fn what_is_no_plain_notation_stays_readable_code() {
        for text in [
            "", "a $ b", "((a)", "a = = b", "<script>", "a & b", "|", "2 ^",
        ] {
            let shown = formula(text);
            assert!(shown.starts_with("<code>"), "{text}: {shown}");
            assert!(!shown.contains("<script"), "{shown}");
        }
        let deep = "(".repeat(150) + "a" + &")".repeat(150);
        assert!(formula(&deep).starts_with("<code>"));
        assert!(formula(&"a ".repeat(5000)).starts_with("<code>"));
    }
}
