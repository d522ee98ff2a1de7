//! How the rows of the relations are stacked in one vector.

use dgd_effects::Relation;
use std::ops::Range;

/// Blocks in one row of the mass balance: differences of pressure need a longer base.
pub(crate) const BALANCE_BLOCKS: usize = 3;

/// The rows of one relation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Section {
    /// A row for each block.
    Friction,
    /// A row for each block.
    Head,
    /// The two outlet transmitters against each other, a row for each block; no row where there is one transmitter.
    Outlets,
    /// A row for each [`BALANCE_BLOCKS`] blocks.
    Balance,
}

impl Section {
    /// In the order in which they are stacked.
    pub(crate) const ALL: [Self; 4] = [Self::Friction, Self::Head, Self::Outlets, Self::Balance];

    pub(crate) fn relation(self) -> Relation {
        match self {
            Self::Friction => Relation::ReturnLineFriction,
            Self::Head => Relation::PumpHead,
            Self::Outlets => Relation::Instrument,
            Self::Balance => Relation::RiserMassBalance,
        }
    }

    pub(crate) fn blocks_per_row(self) -> usize {
        match self {
            Self::Friction | Self::Head | Self::Outlets => 1,
            Self::Balance => BALANCE_BLOCKS,
        }
    }
}

/// How many rows there are of each section.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Layout {
    /// Blocks: as many rows has the friction, and as many the head.
    pub blocks: usize,
    pub outlets: usize,
    pub balance: usize,
}

impl Layout {
    /// Rows of a stacked vector.
    pub(crate) fn len(self) -> usize {
        2 * self.blocks + self.outlets + self.balance
    }

    /// Where the rows of a section stand in it.
    pub(crate) fn rows(self, section: Section) -> Range<usize> {
        let [head, outlets] = [self.blocks, 2 * self.blocks];
        let balance = outlets + self.outlets;
        match section {
            Section::Friction => 0..head,
            Section::Head => head..outlets,
            Section::Outlets => outlets..balance,
            Section::Balance => balance..self.len(),
        }
    }

    /// The rows of every section.
    pub(crate) fn sections(self) -> [Range<usize>; 4] {
        Section::ALL.map(|section| self.rows(section))
    }

    /// The section of a row, and the row's place in that.
    pub(crate) fn place(self, row: usize) -> (Section, usize) {
        let holds = |section: &Section| self.rows(*section).contains(&row);
        let section = Section::ALL.into_iter().find(holds);
        let section = section.unwrap_or(Section::Balance);
        (section, row - self.rows(section).start)
    }

    /// The middle of every row, s from the recording's start, for blocks of so many seconds.
    pub(crate) fn times_s(self, block_s: f64) -> Vec<f64> {
        let mut times = Vec::with_capacity(self.len());
        for section in Section::ALL {
            let row_s = block_s * section.blocks_per_row() as f64;
            times.extend((0..self.rows(section).len()).map(|i| (i as f64 + 0.5) * row_s));
        }
        times
    }

    /// The first block that a row is about.
    pub(crate) fn block(self, row: usize) -> usize {
        let (section, place) = self.place(row);
        place * section.blocks_per_row()
    }
}

#[cfg(test)]
mod tests {
    use super::{Layout, Section};

    #[test]
    fn every_row_stands_in_one_section_and_begins_with_one_block() {
        for outlets in [0, 7] {
            let layout = Layout {
                blocks: 7,
                outlets,
                balance: 2,
            };
            let mut row = 0;
            for section in Section::ALL {
                let rows = layout.rows(section);
                assert_eq!(rows.start, row);
                for place in 0..rows.len() {
                    assert_eq!(layout.place(row), (section, place));
                    assert_eq!(layout.block(row), place * section.blocks_per_row());
                    row += 1;
                }
            }
            assert_eq!(row, layout.len());
        }
    }
}
