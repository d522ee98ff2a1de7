//! What a person is told when a command cannot do its work.

use dgd_documents::DocumentError;
use miette::{GraphicalReportHandler, GraphicalTheme, LabeledSpan, MietteDiagnostic, NamedSource};
use std::error::Error;
use std::fmt;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// Why a command stopped.
#[derive(Debug)]
pub(crate) enum Failure {
    /// The input cannot be used: the file, the place in it, and the mend.
    Input {
        path: PathBuf,
        reason: String,
        help: Option<String>,
    },
    /// A document is wrong; its lines are shown.
    Document {
        path: PathBuf,
        source: String,
        error: DocumentError,
    },
    /// The arguments do not go together.
    Arguments { reason: String },
    /// An output file cannot be written: why, and the mend.
    Write {
        path: PathBuf,
        reason: String,
        help: &'static str,
    },
}

impl Failure {
    pub(crate) fn input(path: &Path, reason: impl fmt::Display) -> Self {
        Self::Input {
            path: path.to_owned(),
            reason: reason.to_string(),
            help: None,
        }
    }

    pub(crate) fn read(path: &Path, error: &std::io::Error) -> Self {
        let help = match error.kind() {
            ErrorKind::NotFound => "check the path; it is relative to the current folder".into(),
            ErrorKind::PermissionDenied => "ask for read permission on the file".into(),
            _ => String::new(),
        };
        let help = (!help.is_empty()).then_some(help);
        Self::Input {
            path: path.to_owned(),
            reason: format!("cannot be read: {error}"),
            help,
        }
    }

    pub(crate) fn write(path: &Path, error: &std::io::Error) -> Self {
        Self::Write {
            path: path.to_owned(),
            reason: error.to_string(),
            help: mend(error.kind()),
        }
    }

    /// An error whose cause may be one of the disk.
    pub(crate) fn write_source(path: &Path, error: &(dyn Error + 'static)) -> Self {
        let mut kind = ErrorKind::Other;
        let mut cause = Some(error);
        while let Some(error) = cause {
            if let Some(disk) = error.downcast_ref::<std::io::Error>() {
                kind = disk.kind();
            }
            cause = error.source();
        }
        Self::Write {
            path: path.to_owned(),
            reason: error.to_string(),
            help: mend(kind),
        }
    }

    /// An output that stands in its own way.
    pub(crate) fn unwritten(path: &Path, reason: impl fmt::Display) -> Self {
        Self::Write {
            path: path.to_owned(),
            reason: reason.to_string(),
            help: mend(ErrorKind::Other),
        }
    }

    /// 2 for input that cannot be used, 1 for output that cannot be written.
    pub(crate) fn status(&self) -> u8 {
        match self {
            Self::Write { .. } => 1,
            Self::Input { .. } | Self::Document { .. } | Self::Arguments { .. } => 2,
        }
    }

    /// The message for standard error.
    pub(crate) fn render(&self) -> String {
        match self {
            Self::Document {
                path,
                source,
                error,
            } => render_document(path, source, error),
            other => format!("error: {other}\n"),
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Input { path, reason, help } => {
                write!(f, "{}: {reason}", path.display())?;
                help.iter()
                    .try_for_each(|help| write!(f, "\n  help: {help}"))
            }
            Self::Document { path, error, .. } => write!(f, "{}: {error}", path.display()),
            Self::Arguments { reason } => f.write_str(reason),
            Self::Write { path, reason, help } => write!(
                f,
                "{} cannot be written: {reason}\n  help: no partial file was left; {help}",
                path.display()
            ),
        }
    }
}

impl Error for Failure {}

/// What to do about an output that the disk refuses.
fn mend(kind: ErrorKind) -> &'static str {
    match kind {
        ErrorKind::StorageFull => "free space or choose another disk",
        ErrorKind::QuotaExceeded => "free some of your quota or choose another disk",
        ErrorKind::FileTooLarge => "raise the file size limit (`ulimit -f`) or choose another disk",
        ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => {
            "ask for permission to write there or choose another place"
        }
        _ => "choose another place",
    }
}

fn render_document(path: &Path, source: &str, error: &DocumentError) -> String {
    let mut rendered = String::new();
    let theme = if crate::say::in_colour() {
        GraphicalTheme::unicode()
    } else {
        GraphicalTheme::unicode_nocolor()
    };
    let handler = GraphicalReportHandler::new_themed(theme).with_links(false);
    for (problem, (line, column)) in error.problems.iter().zip(&error.places) {
        let mut diagnostic = MietteDiagnostic::new(format!(
            "{}:{line}:{column}: {}",
            path.display(),
            problem.message
        ))
        .with_label(LabeledSpan::new_with_span(
            Some("here".into()),
            problem.span.clone(),
        ));
        if let Some(help) = &problem.help {
            diagnostic = diagnostic.with_help(help.clone());
        }
        let name = path.display().to_string();
        let report = miette::Report::new(diagnostic)
            .with_source_code(NamedSource::new(name, source.to_owned()));
        // Rendering into a String cannot fail; the plain text is the fallback all the same.
        if handler
            .render_report(&mut rendered, report.as_ref())
            .is_err()
        {
            rendered.push_str(&problem.message);
        }
    }
    rendered
}
