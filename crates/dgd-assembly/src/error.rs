//! What is wrong with a system or a call, and how to mend it.

use std::fmt;

/// One thing wrong with a description.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Problem {
    /// Where: a component, a property (`tank.area`), a connection, a table (`[free]`).
    pub path: String,
    /// What is wrong, with what was found and what was expected.
    pub message: String,
    /// How to mend it; empty if that is not known.
    pub mend: String,
    /// Line in the text it was read from, from 1.
    pub line: Option<usize>,
}

impl Problem {
    pub(crate) fn new(
        path: impl Into<String>,
        message: impl Into<String>,
        mend: impl Into<String>,
    ) -> Self {
        Self {
            path: path.into(),
            message: message.into(),
            mend: mend.into(),
            line: None,
        }
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(line) = self.line {
            write!(f, "line {line}: ")?;
        }
        write!(f, "{}: {}", self.path, self.message)?;
        if !self.mend.is_empty() {
            write!(f, " ({})", self.mend)?;
        }
        Ok(())
    }
}

/// Everything wrong with a description; never empty.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Problems(pub Vec<Problem>);

impl fmt::Display for Problems {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, problem) in self.0.iter().enumerate() {
            let separator = if index == 0 { "" } else { "\n" };
            write!(f, "{separator}{problem}")?;
        }
        Ok(())
    }
}

/// Why a system was refused, or a call on it.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum AssemblyError {
    /// The text is no TOML, or a key or type is not one of a system.
    #[error("line {line}, column {column}: {message}")]
    Syntax {
        /// Line, from 1.
        line: usize,
        /// Column in characters, from 1.
        column: usize,
        /// What the reader said.
        message: String,
    },
    /// The description is not well posed; every problem found is listed.
    #[error("{0}")]
    IllPosed(Problems),
    /// A column that the record layout names is not in the record.
    #[error("the record has no column `{name}` for {use_}, expected one of: {known}")]
    Column {
        /// Column asked for.
        name: String,
        /// What it was wanted for.
        use_: String,
        /// Columns there are.
        known: String,
    },
    /// A column or slice has the wrong length.
    #[error("`{name}` has {found} entries, expected {expected}")]
    Length {
        /// Argument or column.
        name: String,
        /// Entries expected.
        expected: usize,
        /// Entries found.
        found: usize,
    },
    /// A number is not usable.
    #[error("`{name}` is {found}, expected {expected}")]
    Value {
        /// Argument, parameter or column.
        name: String,
        /// Value found.
        found: f64,
        /// What would have been accepted.
        expected: &'static str,
    },
    /// No instrument that is to be fitted was recorded.
    #[error("no reading of `{names}` was recorded: the columns are missing, or hold no number")]
    NoReadings {
        /// Instruments that are to be fitted.
        names: String,
    },
    /// Too few samples of the record lie in the window.
    #[error(
        "{found} samples of `{part}` lie within {from} to {to}, expected at least {expected}: {why}"
    )]
    Window {
        /// Part of the record.
        part: String,
        /// Window's start.
        from: f64,
        /// Window's end.
        to: f64,
        /// Samples with a value of every input.
        found: usize,
        /// Samples needed.
        expected: usize,
        /// What the record has there.
        why: String,
    },
    /// The independent variable does not ascend.
    #[error(
        "`{name}` is {found} in sample {index}, after {before}; expected finite ascending times"
    )]
    Times {
        /// Column.
        name: String,
        /// Sample, from 1.
        index: usize,
        /// Value found.
        found: f64,
        /// Value before it.
        before: f64,
    },
    /// An effect has no parameter of that name.
    #[error(
        "effect `{effect}` on `{component}` has no parameter `{name}`, expected one of: {known}"
    )]
    Parameter {
        /// Component.
        component: String,
        /// Effect.
        effect: String,
        /// Parameter asked for.
        name: String,
        /// Parameters there are.
        known: String,
    },
    /// Nothing that a fit estimates has that path.
    #[error("no free parameter or free initial state is called `{name}`, expected one of: {known}")]
    Free {
        /// Path asked for.
        name: String,
        /// Paths there are.
        known: String,
    },
    /// An effect is not in the catalogue or does not attach to the component.
    #[error("effect `{effect}` does not attach to `{component}`, expected one of: {known}")]
    Effect {
        /// Component.
        component: String,
        /// Effect.
        effect: String,
        /// Effects that attach to it.
        known: String,
    },
    /// An input was refused.
    #[error(transparent)]
    Input(#[from] dgd_dynamics::inputs::InputError),
    /// The integrator refused its settings.
    #[error(transparent)]
    Integrate(#[from] dgd_dynamics::integrate::IntegrateError),
}

impl AssemblyError {
    /// A component within a chain of connections is looked up from either side: what is wrong with it is told once.
    pub(crate) fn ill(problems: Vec<Problem>) -> Self {
        let mut told: Vec<Problem> = Vec::new();
        for problem in problems {
            if !told.contains(&problem) {
                told.push(problem);
            }
        }
        Self::IllPosed(Problems(told))
    }
}
