//! Is the system well posed? Maximum bipartite matching of equations and unknowns, and the Dulmage-Mendelsohn parts.
//!
//! Dulmage, A. L. and Mendelsohn, N. S., "Coverings of bipartite graphs", Canad. J. Math. 10 (1958); Pothen, A. and Fan,
//! C.-J., ACM Trans. Math. Softw. 16 (1990). Equations: one law a branch, one mass balance a junction without given
//! pressure. Unknowns: one flow a branch, one pressure such a junction.

use crate::build::Slots;
use crate::connect::{Graph, INLET, OUTLET, port_name};
use crate::error::Problem;
use crate::spec::Kind;

/// A bipartite graph of equations (rows) and unknowns (columns).
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Incidence {
    /// Names of the equations.
    pub equations: Vec<String>,
    /// Names of the unknowns.
    pub unknowns: Vec<String>,
    /// Unknowns of each equation.
    pub rows: Vec<Vec<usize>>,
}

/// What does not match in an [`Incidence`].
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Excess {
    /// Equations of the overdetermined part.
    pub equations: Vec<usize>,
    /// Unknowns of the underdetermined part.
    pub unknowns: Vec<usize>,
    /// Equations without a partner in the matching found.
    pub unmatched_equations: Vec<usize>,
    /// Unknowns without a partner in the matching found.
    pub unmatched_unknowns: Vec<usize>,
}

impl Incidence {
    /// Parts of the Dulmage-Mendelsohn decomposition that are not square; all empty if the system is well posed.
    #[must_use]
    pub fn excess(&self) -> Excess {
        let n = self.unknowns.len();
        let mut by_unknown: Vec<Option<usize>> = vec![None; n];
        let mut by_equation: Vec<Option<usize>> = vec![None; self.rows.len()];
        for row in 0..self.rows.len() {
            self.augment(row, &mut by_unknown, &mut by_equation);
        }
        let unmatched_equations: Vec<usize> = (0..self.rows.len())
            .filter(|&r| by_equation[r].is_none())
            .collect();
        let unmatched_unknowns: Vec<usize> = (0..n).filter(|&c| by_unknown[c].is_none()).collect();
        // Alternating paths from the unmatched reach the parts in excess.
        let mut over = vec![false; self.rows.len()];
        let mut stack = unmatched_equations.clone();
        while let Some(row) = stack.pop() {
            if !std::mem::replace(&mut over[row], true) {
                stack.extend(self.rows[row].iter().filter_map(|&c| by_unknown[c]));
            }
        }
        let mut under = vec![false; n];
        let mut stack = unmatched_unknowns.clone();
        while let Some(column) = stack.pop() {
            if !std::mem::replace(&mut under[column], true) {
                let rows = (0..self.rows.len()).filter(|&r| self.rows[r].contains(&column));
                stack.extend(rows.filter_map(|r| by_equation[r]));
            }
        }
        let list = |marks: &[bool]| (0..marks.len()).filter(|&i| marks[i]).collect();
        Excess {
            equations: list(&over),
            unknowns: list(&under),
            unmatched_equations,
            unmatched_unknowns,
        }
    }

    /// Breadth-first search for an augmenting path from `row`; no recursion, so no depth to run out of.
    fn augment(
        &self,
        row: usize,
        by_unknown: &mut [Option<usize>],
        by_equation: &mut [Option<usize>],
    ) {
        let mut reached_by: Vec<Option<usize>> = vec![None; by_unknown.len()];
        let mut queue = std::collections::VecDeque::from([row]);
        while let Some(r) = queue.pop_front() {
            for &c in &self.rows[r] {
                if reached_by[c].is_some() {
                    continue;
                }
                reached_by[c] = Some(r);
                if let Some(next) = by_unknown[c] {
                    queue.push_back(next);
                    continue;
                }
                let mut column = Some(c);
                while let Some(c) = column {
                    let Some(r) = reached_by[c] else { return };
                    column = by_equation[r];
                    by_equation[r] = Some(c);
                    by_unknown[c] = Some(r);
                    if r == row {
                        return;
                    }
                }
            }
        }
    }
}

/// The laws and balances of the graph.
pub(crate) fn incidence(graph: &Graph, slots: &Slots) -> Incidence {
    let branches: Vec<usize> = (0..slots.parts.len())
        .filter(|&i| slots.parts[i].kind.is_branch())
        .collect();
    let free: Vec<usize> = (0..graph.junctions.len())
        .filter(|&m| graph.junctions[m].bearers.is_empty())
        .collect();
    let flow = |part: usize| branches.iter().position(|&b| b == part);
    let pressure = |junction: usize| {
        free.iter()
            .position(|&f| f == junction)
            .map(|p| p + branches.len())
    };
    let mut incidence = Incidence::default();
    for &b in &branches {
        let name = &slots.parts[b].name;
        incidence.unknowns.push(format!("flow through {name}"));
        incidence.equations.push(format!("law of {name}"));
        let mut row: Vec<usize> = flow(b).into_iter().collect();
        if slots.parts[b].kind != Kind::DisplacementPump {
            for end in [INLET, OUTLET] {
                row.extend(graph.of_port.get(&(b, end)).and_then(|&m| pressure(m)));
            }
        }
        incidence.rows.push(row);
    }
    for &m in &free {
        let junction = &graph.junctions[m];
        incidence
            .unknowns
            .push(format!("pressure at {}", junction.name));
        incidence
            .equations
            .push(format!("mass balance at {}", junction.name));
        let mut row: Vec<usize> = junction
            .ends
            .iter()
            .filter_map(|&(part, _)| flow(part))
            .collect();
        row.dedup();
        incidence.rows.push(row);
    }
    incidence
}

/// Contradictions, loose ends and pieces without pressure.
pub(crate) fn check(graph: &Graph, slots: &Slots, problems: &mut Vec<Problem>) {
    for m in &graph.junctions {
        if m.bearers.len() > 1 {
            let names = m.bearer_names.join("` and `");
            problems.push(Problem::new(
                &m.name,
                format!("`{names}` are joined with nothing between"),
                "put a line or valve between them",
            ));
        }
        let lone = m.ends.len() + m.sources.len();
        if m.bearers.is_empty() && lone == 1 {
            let (path, mend) = match (m.ends.first(), m.sources.first()) {
                (Some(&end), _) => (
                    port_name(&slots.parts, end),
                    "connect it to a tank, line or boundary, or to `atmosphere`",
                ),
                (None, Some(&s)) => (
                    slots.parts[s].name.clone(),
                    "connect it to the component that takes its flow",
                ),
                _ => (m.name.clone(), ""),
            };
            problems.push(Problem::new(path, "leads nowhere", mend));
        }
        if lone + m.bearers.len() == 0
            && let Some(&junction) = m.named.first()
        {
            problems.push(Problem::new(
                &slots.parts[junction].name,
                "is connected to nothing",
                "",
            ));
        }
    }
    floating(graph, slots, problems);
    if !problems.is_empty() {
        return; // what is loose would be told again as an excess
    }
    let incidence = incidence(graph, slots);
    let excess = incidence.excess();
    let join = |names: &[String], which: &[usize]| {
        which
            .iter()
            .map(|&i| names[i].as_str())
            .collect::<Vec<_>>()
            .join(", ")
    };
    if !excess.equations.is_empty() {
        let message = format!(
            "too many equations: {}",
            join(&incidence.equations, &excess.equations)
        );
        let mend = if excess.unknowns.is_empty() {
            "remove one of these components, or put a volume between them".to_owned()
        } else {
            format!(
                "nothing determines: {}; two pumps that set the flow must not be in series",
                join(&incidence.unknowns, &excess.unknowns)
            )
        };
        problems.push(Problem::new("connections", message, mend));
    } else if !excess.unknowns.is_empty() {
        let message = format!(
            "nothing determines: {}",
            join(&incidence.unknowns, &excess.unknowns)
        );
        problems.push(Problem::new(
            "connections",
            message,
            "connect a tank, volume or boundary that sets the pressure",
        ));
    }
}

/// Pieces that no pressure holds, and components that hang on nothing.
fn floating(graph: &Graph, slots: &Slots, problems: &mut Vec<Problem>) {
    let n = graph.junctions.len();
    let mut held: Vec<bool> = graph
        .junctions
        .iter()
        .map(|m| !m.bearers.is_empty())
        .collect();
    let mut changed = true;
    while changed {
        changed = false;
        for i in 0..slots.parts.len() {
            let ends = [
                graph.of_port.get(&(i, INLET)),
                graph.of_port.get(&(i, OUTLET)),
            ];
            if let (true, [Some(&a), Some(&b)]) = (slots.parts[i].kind.is_branch(), ends)
                && held[a] != held[b]
            {
                (held[a], held[b], changed) = (true, true, true);
            }
        }
    }
    let loose: Vec<&str> = (0..n)
        .filter(|&m| !held[m] && graph.junctions[m].ends.len() > 1)
        .map(|m| graph.junctions[m].name.as_str())
        .collect();
    if !loose.is_empty() {
        problems.push(Problem::new(
            "connections",
            format!("no pressure is defined in this part: {}", loose.join(", ")),
            "connect it to a tank, volume, pressure boundary or `atmosphere`",
        ));
    }
    for (i, part) in slots.parts.iter().enumerate() {
        let alone = match part.kind {
            Kind::Tank => !graph.of_port.keys().any(|&(p, _)| p == i),
            Kind::Volume => graph.of_port.get(&(i, 0)).is_none_or(|&m| {
                graph.junctions[m].ends.is_empty() && graph.junctions[m].sources.is_empty()
            }),
            Kind::Boundary if !part.gives_flow => graph
                .of_port
                .get(&(i, 0))
                .is_none_or(|&m| graph.junctions[m].ends.is_empty()),
            _ => false,
        };
        if alone {
            problems.push(Problem::new(
                &part.name,
                "is connected to nothing",
                "add it to `connections`, or remove it",
            ));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Incidence;

    fn incidence(rows: &[&[usize]], unknowns: usize) -> Incidence {
        Incidence {
            equations: (0..rows.len()).map(|i| format!("e{i}")).collect(),
            unknowns: (0..unknowns).map(|i| format!("u{i}")).collect(),
            rows: rows.iter().map(|r| r.to_vec()).collect(),
        }
    }

    #[test]
    fn a_square_system_that_needs_augmenting_paths_has_no_excess() {
        let e = incidence(&[&[0, 1], &[0], &[1, 2], &[2, 3]], 4).excess();
        assert!(e.equations.is_empty() && e.unknowns.is_empty());
    }

    #[test]
    fn the_parts_in_excess_are_named_and_the_rest_is_not() {
        // Rows 0-2 want the unknowns 0 and 1; unknowns 2 and 3 share row 3; row 4 and unknown 4 are fine.
        let e = incidence(&[&[0], &[1], &[0, 1], &[2, 3], &[4]], 5).excess();
        assert_eq!(e.equations, [0, 1, 2]);
        assert_eq!(e.unknowns, [2, 3]);
    }
}
