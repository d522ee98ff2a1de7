//! What hydraulic models of rigs leave out: a catalogue, one small module an effect.
//!
//! [`catalogue()`] lists the effects, [`find`] looks one up. An [`Effect`] describes itself ([`About`]: equation, source,
//! parameters, place, what excites it, what it is mistaken for, how it is sought) and acts: sample by sample it reads the [`Moment`] and writes its
//! [`Changes`]. The action is causal and knows neither whether the moment was measured nor simulated: the
//! diagnosis drives it with measurements, [`AugmentedModel::free_run`] with its own states.
//!
//! Adding an effect is one file in `catalogue/` and one line in `catalogue.rs`, or from outside a call of [`register`]; the README shows both. Absent: the search and its
//! statistics, which are the diagnosis's; an effect only says what it must show there ([`Search`]).
#![deny(missing_docs)]

mod augmented;
mod catalogue;
mod correction;
mod curves;
mod effect;
mod moment;
mod own;
mod passing;
mod search;

pub use augmented::{
    AppliedEffect, AugmentedModel, CarriedOver, FreeRun, Inputs, STANDING_PCT, UnknownEffect,
};
pub use catalogue::{catalogue, find, find_taking, told_apart_by, unknown};
pub use correction::{Curve, KNOTS, Place, Quantity};
pub use curves::{
    Curves, FRICTION_TERMS, HEAD_POWERS, HEAD_TERMS, Laminar, Scale, friction_terms, head_terms,
};
pub use dgd_recording::STANDING_M3_S;
pub use effect::{
    About, Action, Component, Effect, End, Extent, MeterPath, Parameter, Relation, Role,
};
pub use moment::{
    Changes, Connection, Moment, Noise, PUMPED_M3_S, START_S, Setting, leaking_m3_s, shrunk,
};
pub use own::{RegisterError, register};
pub use search::{Belief, Excitation, Method, Search, Shown, Timing};

/// The examples of the README compile.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
