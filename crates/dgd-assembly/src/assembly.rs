//! The front door: a checked assembly, its parameters and states.

use crate::assemble::{self, shown_sizes};
use crate::error::{AssemblyError, Problem};
use crate::network::{Network, NodeKind, Start};
use crate::record::Window;
use crate::spec::{Bounds, EffectSetting, Initial, Measured, Setting, System};
use dgd_units::Unit;

/// A system that was found to be well posed, compiled.
///
/// Parameters go by one vector `theta`: the free properties in the order of their paths, then, for each training
/// window, the free initial states ([`parameters`](Self::parameters) names them).
#[derive(Clone)]
pub struct Assembly {
    pub(crate) system: System,
    pub(crate) net: Network,
}

impl std::fmt::Debug for Assembly {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Assembly")
            .field("system", &self.system)
            .finish_non_exhaustive()
    }
}

/// An entry of `theta`.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    /// `"line.roughness"`; `"tank.level"` for a free initial state, with `@2` for the second window and so on.
    pub path: String,
    /// First guess.
    pub start: f64,
    /// Least value.
    pub low: f64,
    /// Greatest value.
    pub high: f64,
    /// Whether it is an initial state.
    pub initial: bool,
}

impl Assembly {
    /// Reads and checks a `system.toml`.
    ///
    /// # Errors
    /// [`AssemblyError::Syntax`] if it is no TOML or holds keys or types no system has, [`AssemblyError::IllPosed`] with
    /// every problem, its line and how to mend it.
    ///
    /// ```
    /// let text = r#"
    /// connections = ["tank -> valve -> atmosphere"]
    /// [components]
    /// tank = { kind = "tank", area = 1.0 }
    /// valve = { kind = "valve", flow_coefficient = 1e-3 }
    /// gauge = { kind = "instrument", measures = "level", of = "tank" }
    /// [initial]
    /// "tank.level" = 2.0
    /// "#;
    /// let assembly = dgd_assembly::Assembly::parse(text)?;
    /// assert_eq!(assembly.states(), ["tank.level"]);
    /// # Ok::<(), dgd_assembly::AssemblyError>(())
    /// ```
    pub fn parse(text: &str) -> Result<Self, AssemblyError> {
        let system = parse_system(text)?;
        Self::new(system).map_err(|error| match error {
            AssemblyError::IllPosed(mut problems) => {
                for problem in &mut problems.0 {
                    problem.line = crate::locate::line_of(text, &problem.path);
                }
                problems.0.sort_by_key(|p| p.line);
                AssemblyError::IllPosed(problems)
            }
            other => other,
        })
    }

    /// Checks and compiles a description.
    ///
    /// # Errors
    /// [`AssemblyError::IllPosed`] with every problem found.
    pub fn new(system: System) -> Result<Self, AssemblyError> {
        let net = assemble::compile(&system)?;
        Ok(Self { system, net })
    }

    /// The description it was compiled from.
    #[must_use]
    pub fn system(&self) -> &System {
        &self.system
    }

    /// Seconds in one unit of the record's times; 1 where its samples stand along something else than time.
    #[must_use]
    pub fn tick_s(&self) -> f64 {
        self.net.tick
    }

    /// The time that effects' drifts and lags are multiples of, s: `[scale] time`, or what the description suggests; in the record's
    /// unit where its samples stand along something else than time.
    #[must_use]
    pub fn usual_time_s(&self) -> f64 {
        let part = self.net.parts.first();
        part.map_or(1.0, |part| part.scale.time_s)
    }

    /// The description as TOML.
    #[must_use]
    pub fn to_toml(&self) -> String {
        // Every value of a `System` is representable; an empty text would be seen at once.
        toml::to_string(&self.system).unwrap_or_default()
    }

    /// Paths of the states, in order.
    #[must_use]
    pub fn states(&self) -> Vec<String> {
        self.net.states.iter().map(|s| s.path.clone()).collect()
    }

    /// Names of the instruments, in order of the outputs.
    #[must_use]
    pub fn outputs(&self) -> Vec<String> {
        self.net.meters.iter().map(|m| m.name.clone()).collect()
    }

    /// Accuracy that is stated of each instrument, as its [`Window::readings`](crate::Window) are: a description gives it
    /// in the instrument's unit, and it is converted as a difference, without a gauge's zero; `None` where none is.
    #[must_use]
    pub fn accuracies(&self) -> Vec<Option<f64>> {
        let stated = |m: &crate::network::Meter| {
            let slot = self.net.parts[m.part].base + crate::kinds::instrument::ACCURACY;
            let accuracy = Some(self.net.values[slot]).filter(|a| a.is_finite())?;
            Some(crate::record::difference(accuracy, m.unit))
        };
        self.net.meters.iter().map(stated).collect()
    }

    /// Paths of the inputs, in order.
    #[must_use]
    pub fn inputs(&self) -> Vec<String> {
        self.net.driven.iter().map(|d| d.path.clone()).collect()
    }

    /// The unit that the channel of an input is read in, to what is carried: of a share, per cent are hundredths. `None` of what is no
    /// input, or has no unit.
    pub fn input_unit(&self, path: &str) -> Option<Unit> {
        let driven = self.net.driven.iter().find(|d| d.path == path)?;
        driven.unit
    }

    /// Number of training windows: one if none is given.
    #[must_use]
    pub fn training_windows(&self) -> usize {
        self.system.record.train.windows.len().max(1)
    }

    /// Number of free properties, which come first in `theta`.
    #[must_use]
    pub fn free_properties(&self) -> usize {
        self.net.free.len()
    }

    /// The entries of `theta`, in its order: free properties by their paths in alphabetical order, then free initial states,
    /// window by window.
    #[must_use]
    pub fn parameters(&self) -> Vec<Parameter> {
        let entry = |path: String, b: &Bounds, initial| Parameter {
            path,
            start: b.start,
            low: b.low,
            high: b.high,
            initial,
        };
        let mut all: Vec<Parameter> = self
            .net
            .free
            .iter()
            .map(|f| entry(f.path.clone(), &f.bounds, false))
            .collect();
        for window in 0..self.training_windows() {
            for state in &self.net.states {
                if let Some(bounds) = state.start.found() {
                    let path = if window == 0 {
                        state.path.clone()
                    } else {
                        format!("{}@{}", state.path, window + 1)
                    };
                    all.push(entry(path, bounds, true));
                }
            }
        }
        all
    }

    /// The starts of all parameters.
    #[must_use]
    pub fn start(&self) -> Vec<f64> {
        self.parameters().iter().map(|p| p.start).collect()
    }

    /// The same system with free values set to `theta` as its starts, so that it can be written down as fitted.
    ///
    /// # Errors
    /// [`AssemblyError::Length`] if `theta` is of another length; [`AssemblyError::IllPosed`] if a value is out of bounds.
    pub fn with_values(&self, theta: &[f64]) -> Result<Self, AssemblyError> {
        self.check_theta(theta)?;
        let mut system = self.system.clone();
        for (free, &value) in self.net.free.iter().zip(theta) {
            if let Some(bounds) = system.free.get_mut(&free.path) {
                bounds.start = value;
            }
        }
        let free_states = self.net.states.iter().filter(|s| s.start.found().is_some());
        for (state, &value) in free_states.zip(&theta[self.net.free.len()..]) {
            if let Some(Initial::Free(bounds)) = system.initial.get_mut(&state.path) {
                bounds.start = value;
            }
        }
        if !system.effects.is_empty() {
            // What effects count in must not follow what was fitted.
            self.keep_sizes(&mut system);
        }
        Self::new(system)
    }

    /// Writes the sizes that the description leaves to be estimated; that of levels only where one holds for all tanks.
    fn keep_sizes(&self, system: &mut System) {
        let Some(scale) = self.net.parts.first().map(|part| part.scale) else {
            return;
        };
        let levels = self
            .net
            .tanks
            .iter()
            .map(|&tank| self.net.parts[tank].scale.level_m);
        let one_level = levels.clone().all(|level| level == scale.level_m);
        let sizes = [
            ("level", scale.level_m),
            ("flow", scale.flow_m3_s),
            ("pressure", scale.pressure_pa),
            ("time", scale.time_s),
        ];
        for (name, size) in sizes {
            if name != "level" || one_level {
                let estimated = Setting::Number(size);
                system.scale.entry(name.to_owned()).or_insert(estimated);
            }
        }
    }

    /// The same system with the usual sizes that a record shows where it has no tank to estimate them from and `[scale]` does not give
    /// them: half of what is recorded of flows and of pressures is larger, and the time is twice the interval between samples.
    ///
    /// # Errors
    /// [`AssemblyError::IllPosed`] as [`Self::new`].
    pub fn sized_by(&self, windows: &[Window]) -> Result<Self, AssemblyError> {
        if !self.net.tanks.is_empty() {
            return Ok(self.clone());
        }
        let mut system = self.system.clone();
        for (name, size) in shown_sizes(&self.net, windows, system.independent == "time") {
            let shown = Setting::Number(size);
            system.scale.entry(name.to_owned()).or_insert(shown);
        }
        Self::new(system)
    }

    /// The same system with states that start from a reading free around it, as far as the first readings of `windows` scatter: all that
    /// follows a start carries its error along, and a fit that took one reading at its word would lay that error to something else.
    ///
    /// # Errors
    /// [`AssemblyError::IllPosed`] as [`Self::new`].
    pub fn with_loose_starts(&self, windows: &[Window]) -> Result<Self, AssemblyError> {
        let mut system = self.system.clone();
        for state in &self.net.states {
            let Start::Measured(meter) = state.start else {
                continue;
            };
            let within = (windows.iter())
                .filter_map(|w| w.readings.get(meter))
                .map(|readings| first_scatter(readings))
                .fold(0.0, f64::max);
            let measured = match system.initial.get(&state.path) {
                Some(Initial::Measured(given)) => given.measured.clone(),
                None => self.net.meters[meter].name.clone(),
                Some(_) => continue,
            };
            if within > 0.0 {
                let within = Some(within);
                let near = Initial::Measured(Measured { measured, within });
                system.initial.insert(state.path.clone(), near);
            }
        }
        Self::new(system)
    }

    /// The same system with an effect on a component. Its parameters named in `free` become free between their bounds,
    /// the strength starting at its usual value; the others stand at their neutral or usual value.
    ///
    /// # Errors
    /// [`AssemblyError::Effect`] if the effect does not attach there, [`AssemblyError::Parameter`] if it has no parameter of a
    /// name in `free`, [`AssemblyError::IllPosed`] if the system with it
    /// contradicts itself.
    pub fn with_effect(
        &self,
        component: &str,
        effect: &str,
        free: &[&str],
    ) -> Result<Self, AssemblyError> {
        let attached = crate::catalogue::effects_for(self);
        let Some(found) = attached
            .iter()
            .find(|a| a.component == component && a.effect == effect)
        else {
            let known = attached
                .iter()
                .filter(|a| a.component == component)
                .map(|a| a.effect);
            return Err(AssemblyError::Effect {
                component: component.into(),
                effect: effect.into(),
                known: crate::build::listed(known),
            });
        };
        let has = |name: &&str| found.parameters.iter().any(|p| p.name == *name);
        if let Some(unknown) = free.iter().find(|name| !has(name)) {
            return Err(AssemblyError::Parameter {
                component: component.into(),
                effect: effect.into(),
                name: (*unknown).into(),
                known: crate::build::listed(found.parameters.iter().map(|p| p.name)),
            });
        }
        let mut system = self.system.clone();
        system.effects.push(EffectSetting {
            component: component.into(),
            effect: effect.into(),
            parameters: Default::default(),
        });
        for parameter in found.parameters.iter().filter(|p| free.contains(&p.name)) {
            let bounds = Bounds {
                start: parameter.usual,
                low: parameter.low,
                high: parameter.high,
            };
            system
                .free
                .insert(format!("{component}.{effect}.{}", parameter.name), bounds);
        }
        Self::new(system)
    }

    /// What is odd about the system although it can be run: inputs that drive nothing measured, free parameters that no
    /// output depends on, tanks that nothing fills.
    #[must_use]
    pub fn warnings(&self) -> Vec<Problem> {
        crate::reach::warnings(self)
    }

    /// The equations in the order they are solved, in words: for people and for drawing.
    #[must_use]
    pub fn edges(&self) -> Vec<Edge> {
        let net = &self.net;
        let place = |node: usize| net.nodes[node].name.clone();
        let mut edges = Vec::new();
        for chain in &net.chains {
            for (k, member) in chain.members.iter().enumerate() {
                let last = chain.members.len() - 1;
                let side = |k: usize| {
                    format!(
                        "{}/{}",
                        net.parts[chain.members[k].part].name,
                        net.parts[chain.members[k + 1].part].name
                    )
                };
                let from = if k == 0 {
                    place(chain.from)
                } else {
                    side(k - 1)
                };
                let to = if k == last { place(chain.to) } else { side(k) };
                let part = &net.parts[member.part];
                let (from, to) = if member.sign < 0.0 {
                    (to, from)
                } else {
                    (from, to)
                };
                edges.push(Edge {
                    component: part.name.clone(),
                    kind: part.kind,
                    from,
                    to,
                });
            }
        }
        for node in &net.nodes {
            for &source in &node.sources {
                let part = &net.parts[source];
                edges.push(Edge {
                    component: part.name.clone(),
                    kind: part.kind,
                    from: part.name.clone(),
                    to: node.name.clone(),
                });
            }
        }
        edges
    }

    pub(crate) fn check_theta(&self, theta: &[f64]) -> Result<(), AssemblyError> {
        let expected = self.parameters().len();
        if theta.len() != expected {
            return Err(AssemblyError::Length {
                name: "theta".into(),
                expected,
                found: theta.len(),
            });
        }
        if let Some((p, &found)) = self
            .parameters()
            .iter()
            .zip(theta)
            .find(|(_, t)| !t.is_finite())
        {
            return Err(AssemblyError::Value {
                name: p.path.clone(),
                found,
                expected: "a finite number",
            });
        }
        Ok(())
    }

    /// Whether `node` is a port of tank number `tank`.
    pub(crate) fn is_port(&self, node: usize, tank: usize) -> bool {
        matches!(self.net.nodes[node].kind, NodeKind::Port { tank: k, .. } if k == tank)
    }
}

/// A branch or flow boundary between two places, for drawing.
#[derive(Debug, Clone, PartialEq)]
pub struct Edge {
    /// Component.
    pub component: String,
    /// Its kind.
    pub kind: crate::Kind,
    /// Where its inlet is: `"tank.outlet"`, a node, or `"pump/line"` between two branches.
    pub from: String,
    /// Where its outlet is.
    pub to: String,
}

/// Reads the types of a `system.toml` without checking what they say.
///
/// # Errors
/// [`AssemblyError::Syntax`].
pub fn parse_system(text: &str) -> Result<System, AssemblyError> {
    toml::from_str(text).map_err(|error| {
        let offset = error.span().map_or(0, |s| s.start);
        let (line, column) = crate::locate::line_and_column(text, offset);
        AssemblyError::Syntax {
            line,
            column,
            message: crate::near::with_meant(&error.message().trim().replace('\n', "; ")),
        }
    })
}

/// How far the first of these readings may be off by chance: eight times what consecutive ones scatter about a parabola, or their least
/// step if that is more. 0 of what does not scatter.
fn first_scatter(readings: &[f64]) -> f64 {
    /// Readings that are looked at.
    const FIRST: usize = 200;
    const TIMES: f64 = 8.0;
    let first: Vec<f64> = (readings.iter().copied())
        .filter(|v| v.is_finite())
        .take(FIRST)
        .collect();
    // Third differences of white noise have twenty times its variance.
    let third = |w: &[f64]| w[3] - 3.0 * w[2] + 3.0 * w[1] - w[0];
    let mut size: Vec<f64> = first.windows(4).map(|w| third(w).abs()).collect();
    if size.is_empty() {
        return 0.0;
    }
    size.sort_by(f64::total_cmp);
    // The median of what is normally distributed, against its standard deviation.
    let noise = size[size.len() / 2] / 0.674_5 / 20f64.sqrt();
    let steps = first.windows(2).map(|w| (w[1] - w[0]).abs());
    let step = steps.filter(|s| *s > 0.0).fold(f64::INFINITY, f64::min);
    (TIMES * noise).max(if step.is_finite() { step } else { 0.0 })
}
