//! An assembly as its field draws it: components with their symbols, connections, instruments.

mod layout;
mod symbol;

use crate::color::{INK, Role, SOFT_INK};
use crate::error::ReportError;
use crate::figure::Figure;
use crate::font::{shorten, text_width};
use crate::panel::WIDTH;
use crate::scene::{Anchor, Pen, Scene};
use layout::{Layout, Slot};

const MOST: usize = 400;
const CELL: f64 = 268.0;
/// From the left edge of a cell to the middle of its symbol.
const MIDDLE: f64 = 60.0;
/// From the middle of a symbol to its words.
const WORDS: f64 = 38.0;
const MARGIN: f64 = 14.0;
const LANE: f64 = 12.0;
const GAP: f64 = 30.0;
const LINE: f64 = 15.0;
const INSTRUMENT: f64 = 27.0;
const PIPE: f64 = 1.8;

/// What a component is drawn as.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Symbol {
    /// Vessel with a free surface.
    Tank,
    /// Full, pressurised vessel.
    Volume,
    /// Pipe.
    Line,
    /// Pump whose head falls with flow.
    CentrifugalPump,
    /// Pump that delivers by its stroke.
    DisplacementPump,
    /// Valve.
    Valve,
    /// Orifice or bit.
    Orifice,
    /// Where a pressure or a flow is given.
    Boundary,
    /// Where pipes meet.
    Junction,
    /// The open air.
    Atmosphere,
}

/// A component of a [`Diagram`].
#[derive(Debug, Clone, PartialEq)]
pub struct DrawnComponent {
    /// Name, drawn bold.
    pub name: String,
    /// Symbol.
    pub symbol: Symbol,
    /// Lines under the name: sizes, what drives it.
    pub notes: Vec<String>,
    /// Lines in the model's colour: what is free.
    pub marks: Vec<String>,
    /// Instruments on it.
    pub instruments: Vec<DrawnInstrument>,
}

/// An instrument.
#[derive(Debug, Clone, PartialEq)]
pub struct DrawnInstrument {
    /// One to three letters of ISA-5.1, such as `LT`.
    pub letters: String,
    /// Name and unit.
    pub label: String,
}

/// A connection, in the direction of flow.
#[derive(Debug, Clone, PartialEq)]
pub struct DrawnLink {
    /// Index of the component it leaves.
    pub from: usize,
    /// Index of the component it enters.
    pub to: usize,
    /// Words at its start, such as the port it leaves by; may be empty.
    pub leaves: String,
    /// Words at its end.
    pub enters: String,
}

/// An assembly to be drawn.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Diagram {
    /// Components, in the order in which they are to be placed.
    pub components: Vec<DrawnComponent>,
    /// Connections.
    pub links: Vec<DrawnLink>,
    /// The caption.
    pub caption: String,
}

/// Draws an assembly from top to bottom in the direction of flow; what flows back runs up at the left.
///
/// # Errors
/// [`ReportError::TooMany`] above 400 components or connections, [`ReportError::Length`] if a connection names a component that
/// is not there.
///
/// ```
/// use dgd_report::{Diagram, DrawnComponent, DrawnLink, Symbol, assembly_drawing};
/// let part = |name: &str, symbol| DrawnComponent {
///     name: name.into(), symbol, notes: vec![], marks: vec![], instruments: vec![],
/// };
/// let link = |from, to| DrawnLink { from, to, leaves: String::new(), enters: String::new() };
/// let diagram = Diagram {
///     components: vec![part("pit", Symbol::Tank), part("pump", Symbol::CentrifugalPump)],
///     links: vec![link(0, 1), link(1, 0)],
///     caption: "A pit that is stirred by its pump.".into(),
/// };
/// assert!(assembly_drawing(&diagram)?.svg().contains("pump"));
/// # Ok::<(), dgd_report::ReportError>(())
/// ```
pub fn assembly_drawing(diagram: &Diagram) -> Result<Figure, ReportError> {
    let count = diagram.components.len();
    for (what, found) in [("components", count), ("connections", diagram.links.len())] {
        if found > MOST {
            return Err(ReportError::TooMany {
                what,
                found,
                most: MOST,
            });
        }
    }
    if let Some(link) = diagram.links.iter().find(|l| l.from.max(l.to) >= count) {
        return Err(ReportError::Length {
            name: "components",
            expected: link.from.max(link.to) + 1,
            found: count,
        });
    }
    let pairs: Vec<(usize, usize)> = diagram.links.iter().map(|l| (l.from, l.to)).collect();
    let layout = layout::arrange(count, &pairs);
    let mut drawing = Drawing::new(diagram, &layout);
    drawing.pipes();
    drawing.components();
    Ok(Figure::of_scene(diagram.caption.clone(), drawing.scene))
}

struct Drawing<'a> {
    diagram: &'a Diagram,
    layout: &'a Layout,
    scene: Scene,
    /// Left edge of the first column.
    left: f64,
    /// Top and height of each row of components.
    rows: Vec<(f64, f64)>,
}

/// Height of what stands beside a symbol.
fn height(component: &DrawnComponent) -> f64 {
    let small = component.symbol == Symbol::Junction && component.notes.is_empty();
    let lines = (component.notes.len() + component.marks.len()) as f64;
    let words = 20.0 + LINE * lines + INSTRUMENT * component.instruments.len() as f64;
    words.max(if small { 24.0 } else { symbol::HEIGHT + 6.0 })
}

impl<'a> Drawing<'a> {
    fn new(diagram: &'a Diagram, layout: &'a Layout) -> Self {
        let lanes = layout.back.len();
        let own = 2.0 * MARGIN + LANE * lanes as f64 + CELL * layout.columns.max(1) as f64;
        // A narrow drawing stands in the middle of the width that all figures have.
        let left = MARGIN + LANE * lanes as f64 + (0.5 * (WIDTH - own)).max(0.0);
        let mut top = MARGIN;
        if lanes > 0 {
            top += GAP;
        }
        let mut rows = Vec::new();
        for row in 0..layout.rows {
            let in_row = (0..diagram.components.len()).filter(|&c| layout.places[c].row == row);
            let tall = in_row
                .map(|c| height(&diagram.components[c]))
                .fold(24.0, f64::max);
            rows.push((top, tall));
            top += tall + GAP + 8.0 * layout.lanes_below(row).saturating_sub(1) as f64;
        }
        let foot = if lanes > 0 { GAP } else { 0.0 };
        Self {
            diagram,
            layout,
            scene: Scene {
                width: own.max(WIDTH),
                height: (top - GAP + foot + MARGIN).max(40.0),
                ..Scene::default()
            },
            left,
            rows,
        }
    }

    fn x(&self, slot: Slot) -> f64 {
        self.left + CELL * slot.column as f64 + MIDDLE
    }

    /// Middle of a component's symbol.
    fn middle(&self, component: usize) -> [f64; 2] {
        let slot = self.layout.places[component];
        let (top, _) = self.rows[slot.row];
        let tall = symbol::height(self.diagram.components[component].symbol);
        let own = symbol::HEIGHT.min(height(&self.diagram.components[component]));
        [self.x(slot), top + own.max(tall) / 2.0]
    }

    /// Where a pipe enters and leaves.
    fn ends(&self, component: usize) -> [f64; 2] {
        let half = symbol::height(self.diagram.components[component].symbol) / 2.0;
        let y = self.middle(component)[1];
        [y - half, y + half]
    }

    fn pipes(&mut self) {
        let pen = Pen::new(INK, PIPE);
        let layout = self.layout;
        for path in &layout.paths {
            let link = &self.diagram.links[path.link];
            let mut points = vec![[self.middle(link.from)[0], self.ends(link.from)[1]]];
            for (slot, lane) in path.via.iter().zip(&path.lanes) {
                self.turn(&mut points, *slot, *lane);
            }
            let goal = layout.places[link.to];
            if let Some(lane) = path.lanes.last() {
                self.turn(&mut points, goal, *lane);
            }
            points.push([self.x(goal), self.ends(link.to)[0]]);
            self.pipe(points, link, pen);
        }
        for (lane, index) in layout.back.iter().enumerate() {
            let link = &self.diagram.links[*index];
            let x = self.left - LANE * (layout.back.len() - lane) as f64;
            let (from, to) = (self.middle(link.from)[0], self.middle(link.to)[0]);
            let (leave, enter) = (self.ends(link.from)[1], self.ends(link.to)[0]);
            let row = self.rows[layout.places[link.from].row];
            let below = (row.0 + row.1 + 8.0).max(leave + 8.0) + 4.0 * lane as f64;
            let above = self.rows[layout.places[link.to].row].0 - 16.0 - 4.0 * lane as f64;
            let points = vec![
                [from, leave],
                [from, below],
                [x, below],
                [x, above],
                [to, above],
                [to, enter],
            ];
            self.pipe(points, link, pen);
        }
    }

    /// Down from the last point and across, in the gap above the row of `slot`.
    fn turn(&self, points: &mut Vec<[f64; 2]>, slot: Slot, lane: usize) {
        let x = self.x(slot);
        let Some(&[from, _]) = points.last() else {
            return;
        };
        if (from - x).abs() > 0.5 {
            let y = self.rows[slot.row].0 - 17.0 - 8.0 * lane as f64;
            points.extend([[from, y], [x, y]]);
        }
    }

    fn pipe(&mut self, points: Vec<[f64; 2]>, link: &DrawnLink, pen: Pen) {
        let (Some(&first), Some(&[x, y])) = (points.first(), points.last()) else {
            return;
        };
        self.scene.lines(vec![points], pen);
        self.scene
            .polygon(vec![[x - 4.5, y - 8.5], [x + 4.5, y - 8.5], [x, y]], INK);
        let words = [
            ([first[0], first[1] + 13.0], &link.leaves),
            ([x, y - 8.0], &link.enters),
        ];
        for (at, word) in words {
            if !word.is_empty() {
                let word = shorten(word, 11.5, MIDDLE - 10.0);
                let at = [at[0] - 8.0, at[1]];
                self.scene.text(at, &word, 11.5, SOFT_INK, Anchor::End);
            }
        }
    }

    fn components(&mut self) {
        let diagram = self.diagram;
        for (index, component) in diagram.components.iter().enumerate() {
            let at = self.middle(index);
            let tap = [at[0] + symbol::width(component.symbol) / 2.0, at[1]];
            symbol::draw(&mut self.scene, component.symbol, at);
            let x = at[0] + WORDS;
            let room = CELL - MIDDLE - WORDS - 8.0;
            let mut y = self.rows[self.layout.places[index].row].0 + 14.0;
            if component.notes.is_empty()
                && component.marks.is_empty()
                && component.instruments.is_empty()
            {
                y = at[1] + 5.0;
            }
            let name = shorten(&component.name, 14.0 * 1.1, room);
            self.scene.bold([x, y], &name, 14.0, INK, Anchor::Start);
            let marked = Role::Model.color();
            let notes = component.notes.iter().map(|n| (n, SOFT_INK));
            for (text, color) in notes.chain(component.marks.iter().map(|n| (n, marked))) {
                y += LINE;
                self.scene.text(
                    [x, y],
                    &shorten(text, 12.0, room),
                    12.0,
                    color,
                    Anchor::Start,
                );
            }
            for instrument in &component.instruments {
                y += INSTRUMENT;
                self.instrument(instrument, tap, [x, y - 6.0], room);
            }
        }
    }

    fn instrument(&mut self, instrument: &DrawnInstrument, of: [f64; 2], at: [f64; 2], room: f64) {
        let radius = 11.5;
        let centre = [at[0] + radius, at[1]];
        let signal = Pen {
            dash: Some([3.0, 3.0]),
            ..Pen::new(Role::Input(0).color(), 1.2)
        };
        let gutter = at[0] - 9.0;
        let path = vec![of, [gutter, of[1]], [gutter, at[1]], [at[0], at[1]]];
        self.scene.lines(vec![path], signal);
        self.scene
            .ring(centre, radius, Pen::new(Role::Input(0).color(), 1.5));
        let letters = shorten(&instrument.letters, 10.5, 2.0 * radius);
        let size = if text_width(&letters, 10.5, false) > 18.0 {
            9.0
        } else {
            10.5
        };
        self.scene.text(
            [centre[0], at[1] + 3.7],
            &letters,
            size,
            INK,
            Anchor::Middle,
        );
        let label = shorten(&instrument.label, 12.0, room - 2.0 * radius - 6.0);
        let from = [at[0] + 2.0 * radius + 6.0, at[1] + 4.2];
        self.scene.text(from, &label, 12.0, INK, Anchor::Start);
    }
}
