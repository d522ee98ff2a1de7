//! One module a command.

mod carried;
pub(crate) mod catalogue;
pub(crate) mod convert;
pub(crate) mod demo;
pub(crate) mod diagnose;
pub(crate) mod fit;
pub(crate) mod free_run;
pub(crate) mod inspect;
pub(crate) mod linearise;
pub(crate) mod mask;
pub(crate) mod sensitivities;
pub(crate) mod simulate;
pub(crate) mod system_check;
pub(crate) mod system_diagnose;
pub(crate) mod system_fit;
pub(crate) mod system_kinds;
pub(crate) mod system_simulate;
