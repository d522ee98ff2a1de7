//! Names of plain notation as MathML: letters, subscripts, Greek, words.

use crate::xml::escape;

const FUNCTIONS: [&str; 12] = [
    "sin", "cos", "tan", "exp", "log", "ln", "max", "min", "tanh", "abs", "sign", "erf",
];

/// A word of the language rather than a letter of the equation.
pub(super) fn is_word(name: &str) -> bool {
    let base = name.split('_').next().unwrap_or(name);
    !name.contains('_')
        && greek(base).is_none()
        && !FUNCTIONS.contains(&base)
        && split_index(base).is_none()
        && base.chars().count() > 1
        && !matches!(base, "Re" | "dp" | "dq" | "dt" | "dh" | "dv" | "dT")
}

/// A name with its subscript.
pub(super) fn symbol(name: &str) -> String {
    let (base, below) = match name.split_once('_') {
        Some((base, below)) if !base.is_empty() && !below.is_empty() => (base, Some(below)),
        _ => (name, None),
    };
    let (base, below) = match (below, split_index(base)) {
        (None, Some((letters, digits))) => (letters, Some(digits)),
        _ => (base, below),
    };
    let base = letters(base);
    match below {
        None => base,
        Some(below) => {
            let parts: Vec<String> = below
                .split([',', '_'])
                .filter(|part| !part.is_empty())
                .map(index_part)
                .collect();
            let comma = if below.contains(',') {
                "<mo separator=\"true\">,</mo>"
            } else {
                "<mspace width=\"0.2em\"/>"
            };
            format!("<msub>{base}<mrow>{}</mrow></msub>", parts.join(comma))
        }
    }
}

/// `c1` is c with index 1.
fn split_index(name: &str) -> Option<(&str, &str)> {
    let cut = name.find(|c: char| c.is_ascii_digit())?;
    let (letters, digits) = name.split_at(cut);
    (!letters.is_empty()
        && letters.chars().count() <= 2
        && digits.chars().all(|c| c.is_ascii_digit()))
    .then_some((letters, digits))
}

fn index_part(part: &str) -> String {
    if part.chars().all(|c| c.is_ascii_digit()) {
        format!("<mn>{part}</mn>")
    } else if part.chars().count() == 1 {
        format!("<mi>{}</mi>", escape(part))
    } else if let Some(letter) = greek(part) {
        format!("<mi>{letter}</mi>")
    } else {
        format!("<mtext>{}</mtext>", escape(part))
    }
}

fn letters(name: &str) -> String {
    if let Some(letter) = greek(name) {
        return format!("<mi>{letter}</mi>");
    }
    if FUNCTIONS.contains(&name) || name == "Re" {
        return format!("<mi mathvariant=\"normal\">{name}</mi>");
    }
    // A pressure drop, not a product of two letters.
    if let Some(of) = name.strip_prefix('d').filter(|of| of.chars().count() == 1) {
        return format!(
            "<mrow><mi mathvariant=\"normal\">Δ</mi><mi>{}</mi></mrow>",
            escape(of)
        );
    }
    if name.chars().count() == 1 {
        return format!("<mi>{}</mi>", escape(name));
    }
    format!("<mtext>{}</mtext>", escape(name))
}

fn greek(name: &str) -> Option<&'static str> {
    Some(match name {
        "alpha" => "α",
        "beta" => "β",
        "gamma" => "γ",
        "delta" => "δ",
        "Delta" => "Δ",
        "eps" | "epsilon" => "ε",
        "zeta" => "ζ",
        "eta" => "η",
        "theta" => "θ",
        "kappa" => "κ",
        "lambda" => "λ",
        "mu" => "μ",
        "nu" => "ν",
        "xi" => "ξ",
        "pi" => "π",
        "rho" => "ρ",
        "sigma" => "σ",
        "tau" => "τ",
        "phi" => "φ",
        "chi" => "χ",
        "psi" => "ψ",
        "omega" => "ω",
        "inf" | "infinity" => "∞",
        _ => return None,
    })
}
