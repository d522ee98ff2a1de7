//! Steps of the chain that can be left out, so that what each contributes can be measured.

/// A step of the chain. `cargo xtask prove --ablate` runs a proof without each in turn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Step {
    /// Mud pump and return meter may be late by part of a second in the mass balance.
    LateFlows,
    /// What the meter of the return flow reads after a stop of the pump tells a delay from a store.
    Stops,
    /// What sets in or passes must show without the minutes about its edges.
    Edges,
    /// What comes upon flowing mud must show without the stops.
    Flowing,
    /// Likely causes are compared with their forms within error.
    Form,
    /// A further effect must stand out from the slack of those named before.
    Slack,
    /// What the form of a named effect leaves over raises the hurdle of the next.
    Footprints,
    /// Signatures are projected off the tangent of the base model, which is fitted again.
    Projection,
    /// Empirical corrections compete: without them nothing is called `unknown`.
    Corrections,
    /// A correction loses what its busiest ten minutes bring.
    Busiest,
    /// Where a correction tells more than any effect, what sets in is weighed as what ends as well.
    Ends,
    /// Before `unknown`, a second effect beside the best is tried: it may do what a correction does, or bend the best one's form.
    TwoDo,
    /// What the relations keep beyond that of sound recordings once the search has ended is `unknown`.
    Remains,
    /// A line whose friction laminar flow explains better is searched anew with it.
    Laminar,
    /// Probabilities are brought to the share of findings that are right, and standard errors of sizes to intervals that hold 95 %.
    Calibration,
}

impl Step {
    /// Every step, in the order of the chain.
    pub const ALL: [Self; 15] = [
        Self::Projection,
        Self::LateFlows,
        Self::Stops,
        Self::Edges,
        Self::Flowing,
        Self::Form,
        Self::Slack,
        Self::Footprints,
        Self::Corrections,
        Self::Busiest,
        Self::Ends,
        Self::TwoDo,
        Self::Remains,
        Self::Laminar,
        Self::Calibration,
    ];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::LateFlows => "late-flows",
            Self::Stops => "stops",
            Self::Edges => "edges",
            Self::Flowing => "flowing",
            Self::Form => "form",
            Self::Slack => "slack",
            Self::Footprints => "footprints",
            Self::Projection => "projection",
            Self::Corrections => "corrections",
            Self::Busiest => "busiest",
            Self::Ends => "ends",
            Self::TwoDo => "two-do",
            Self::Remains => "remains",
            Self::Laminar => "laminar",
            Self::Calibration => "calibration",
        }
    }
}
