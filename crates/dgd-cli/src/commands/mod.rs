//! One module a command.

pub(crate) mod convert;
pub(crate) mod demo;
pub(crate) mod diagnose;
pub(crate) mod fit;
pub(crate) mod free_run;
pub(crate) mod inspect;
pub(crate) mod mask;
pub(crate) mod simulate;
