//! Rows and columns of a diagram: longest paths give rows, parents give columns (Sugiyama, Tagawa and Toda 1981).

use std::collections::{BTreeMap, BTreeSet};

/// Cell of the grid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Slot {
    pub row: usize,
    pub column: usize,
}

/// How a connection runs downwards.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Path {
    /// Index of the connection.
    pub link: usize,
    /// Cells it passes through between its ends.
    pub via: Vec<Slot>,
    /// Track in each gap it crosses.
    pub lanes: Vec<usize>,
}

/// A diagram on a grid.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Layout {
    pub places: Vec<Slot>,
    pub rows: usize,
    pub columns: usize,
    pub paths: Vec<Path>,
    /// Connections that run back up.
    pub back: Vec<usize>,
    /// Tracks in the gap above each row.
    tracks: Vec<usize>,
}

impl Layout {
    /// Tracks in the gap below a row.
    pub(crate) fn lanes_below(&self, row: usize) -> usize {
        self.tracks.get(row + 1).copied().unwrap_or(0)
    }
}

/// Places `count` components by their connections `(from, to)`.
pub(crate) fn arrange(count: usize, links: &[(usize, usize)]) -> Layout {
    let back = backwards(count, links);
    let down: Vec<usize> = (0..links.len()).filter(|l| !back.contains(l)).collect();
    let rows = rows(count, links, &down);
    let depth = rows.iter().max().map_or(0, |r| r + 1);
    // A connection over several rows takes a cell in each it passes.
    let mut cells: Vec<Vec<Cell>> = vec![Vec::new(); depth];
    for (component, &row) in rows.iter().enumerate() {
        cells[row].push(Cell {
            component: Some(component),
            parents: Vec::new(),
            column: 0,
        });
    }
    let mut passing: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for &link in &down {
        let (from, to) = links[link];
        let mut parent = find(&cells[rows[from]], from);
        for row in rows[from] + 1..rows[to] {
            let parents = parent.into_iter().collect();
            cells[row].push(Cell {
                component: None,
                parents,
                column: 0,
            });
            parent = Some(cells[row].len() - 1);
            passing.entry(link).or_default().push(cells[row].len() - 1);
        }
        let goal = find(&cells[rows[to]], to);
        if let (Some(goal), Some(parent)) = (goal, parent) {
            cells[rows[to]][goal].parents.push(parent);
        }
    }
    columns(&mut cells);
    let mut layout = Layout {
        places: vec![Slot::default(); count],
        rows: depth,
        columns: cells
            .iter()
            .flatten()
            .map(|c| c.column + 1)
            .max()
            .unwrap_or(0),
        back: back.into_iter().collect(),
        tracks: vec![0; depth],
        ..Layout::default()
    };
    for (row, here) in cells.iter().enumerate() {
        for cell in here {
            if let Some(component) = cell.component {
                layout.places[component] = Slot {
                    row,
                    column: cell.column,
                };
            }
        }
    }
    // In each gap, what goes to one cell shares a track.
    let mut goals: Vec<Vec<usize>> = vec![Vec::new(); depth];
    for &link in &down {
        let (from, to) = links[link];
        let chosen = passing.get(&link).map_or(&[][..], Vec::as_slice);
        let via: Vec<Slot> = chosen
            .iter()
            .zip(rows[from] + 1..)
            .map(|(&cell, row)| Slot {
                row,
                column: cells[row][cell].column,
            })
            .collect();
        let mut here = layout.places[from];
        let mut lanes = Vec::new();
        for &next in via.iter().chain([&layout.places[to]]) {
            let known = goals[next.row].iter().position(|c| *c == next.column);
            lanes.push(match known {
                _ if here.column == next.column => 0,
                Some(lane) => lane,
                None => {
                    goals[next.row].push(next.column);
                    goals[next.row].len() - 1
                }
            });
            here = next;
        }
        layout.paths.push(Path { link, via, lanes });
    }
    layout.tracks = goals.iter().map(Vec::len).collect();
    layout
}

#[derive(Debug, Clone)]
struct Cell {
    /// `None`: a connection passes through.
    component: Option<usize>,
    /// Cells of the row above that lead here.
    parents: Vec<usize>,
    column: usize,
}

fn find(cells: &[Cell], component: usize) -> Option<usize> {
    cells.iter().position(|c| c.component == Some(component))
}

/// Connections that close a circle, by a search in depth from the components that nothing enters.
fn backwards(count: usize, links: &[(usize, usize)]) -> BTreeSet<usize> {
    let entered: BTreeSet<usize> = links.iter().map(|l| l.1).collect();
    let order = (0..count).filter(|c| !entered.contains(c)).chain(0..count);
    // 0: not seen, 1: on the present path, 2: done.
    let mut seen = vec![0_u8; count];
    let mut back = BTreeSet::new();
    for start in order {
        if seen[start] > 0 {
            continue;
        }
        seen[start] = 1;
        let mut stack = vec![(start, 0)];
        while let Some((node, next)) = stack.pop() {
            let Some(link) = (next..links.len()).find(|&l| links[l].0 == node) else {
                seen[node] = 2;
                continue;
            };
            stack.push((node, link + 1));
            let to = links[link].1;
            match seen[to] {
                0 => {
                    seen[to] = 1;
                    stack.push((to, 0));
                }
                1 => {
                    back.insert(link);
                }
                _ => {}
            }
        }
    }
    back
}

/// Row of each component: its longest way from a source; sources themselves right above where they lead.
fn rows(count: usize, links: &[(usize, usize)], down: &[usize]) -> Vec<usize> {
    let mut rows = vec![0; count];
    // Without circles this settles within `count` rounds.
    for _ in 0..count {
        for &l in down {
            let (from, to) = links[l];
            rows[to] = rows[to].max(rows[from] + 1);
        }
    }
    let fed: BTreeSet<usize> = down.iter().map(|&l| links[l].1).collect();
    for _ in 0..count {
        for node in 0..count {
            let below = down
                .iter()
                .filter(|&&l| links[l].0 == node)
                .map(|&l| rows[links[l].1])
                .min();
            // Only what hangs on nothing else may come down: a source, or what has come down with it.
            let above = down
                .iter()
                .filter(|&&l| links[l].1 == node)
                .map(|&l| rows[links[l].0])
                .max();
            if let Some(below) = below
                && below > rows[node] + 1
                && (!fed.contains(&node) || above.is_some())
            {
                rows[node] = below - 1;
            }
        }
    }
    rows
}

/// Columns: below their parents where there is room, in an order that crosses little.
fn columns(cells: &mut [Vec<Cell>]) {
    for row in 0..cells.len() {
        let (above, rest) = cells.split_at_mut(row);
        let Some(here) = rest.first_mut() else {
            continue;
        };
        let last = row.checked_sub(1).map(|r| &above[r]);
        let wish = |cell: &Cell| -> Option<usize> {
            let last = last?;
            cell.parents
                .iter()
                .filter_map(|&p| last.get(p))
                .map(|c| c.column)
                .min()
        };
        let mut order: Vec<usize> = (0..here.len()).collect();
        // What has no parent stands right of all that has.
        order.sort_by_key(|&i| wish(&here[i]).unwrap_or(usize::MAX));
        let mut next = 0;
        for i in order {
            let column = wish(&here[i]).map_or(next, |w| w.max(next));
            here[i].column = column;
            next = column + 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chain_stands_in_one_column() {
        let layout = arrange(3, &[(0, 1), (1, 2)]);
        let at: Vec<(usize, usize)> = layout.places.iter().map(|p| (p.row, p.column)).collect();
        assert_eq!(at, [(0, 0), (1, 0), (2, 0)]);
        assert_eq!(layout.lanes_below(0), 0);
    }

    #[test]
    fn what_closes_a_circle_runs_back() {
        let layout = arrange(3, &[(0, 1), (1, 2), (2, 0)]);
        assert_eq!(layout.back, [2]);
        assert_eq!(layout.rows, 3);
    }

    #[test]
    fn a_source_stands_right_above_what_it_feeds() {
        // A long chain, and a feed into its last member.
        let layout = arrange(5, &[(0, 1), (1, 2), (2, 3), (4, 3)]);
        assert_eq!(layout.places[4], Slot { row: 2, column: 1 });
        assert_eq!(layout.lanes_below(2), 1);
    }

    #[test]
    fn a_connection_over_several_rows_keeps_clear_of_components() {
        // The short cut from 0 to 3 passes beside 1 and 2.
        let layout = arrange(4, &[(0, 1), (1, 2), (2, 3), (0, 3)]);
        let short_cut = layout.paths.iter().find(|p| p.link == 3);
        let via = short_cut.map(|p| p.via.clone()).unwrap_or_default();
        assert_eq!(via.len(), 2);
        assert!(via.iter().all(|v| !layout.places.contains(v)), "{via:?}");
    }
}
