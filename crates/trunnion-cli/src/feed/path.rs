//! A table of axis positions and derivatives as an axis path.

use super::args::{FeedArgs, FeedMethod};
use super::layout::{JumpPosition, Layout, Next, PieceInterval, ThirdTolerance, columns};
use super::run::AxisTable;
use crate::outcome::Failure;
use crate::table::{Ends, Faults, Rows};
use std::path::PathBuf;
use trunnion::feed::{GivenSpeed, Limits};
use trunnion::files::limits::LimitsFile;
use trunnion::files::table::TableHeader;
use trunnion::types::{AxisNode, AxisPath, AxisPiece, Diagnostic, Diagnostics, Motion};

/// Table and the meaning of its columns.
pub(super) struct Table {
    name: PathBuf,
    rows: Rows,
    pub(super) layout: Layout,
}

/// Rest of the axes inside the path.
pub(super) struct Rest {
    pub(super) s: f64,
    pub(super) line: u32,
    /// Derivative that jumps, and by how much; `None` if the row is only repeated.
    pub(super) jump: Option<(String, f64)>,
}

impl Table {
    /// Reads the table. Its axes are those of the limits file; others have no limits, which is a fault.
    pub(super) fn read(
        ends: &Ends,
        limits: &LimitsFile,
        method: FeedMethod,
    ) -> Result<Self, Failure> {
        let rows = ends.read(|header| columns(header, limits, method))?;
        let layout = Layout::new(&rows.names, limits);
        Ok(Self { name: ends.name().to_owned(), rows, layout })
    }

    /// Takes the columns of a table in memory; rows count from 1.
    pub(super) fn of_values(
        table: AxisTable<'_>,
        limits: &LimitsFile,
        method: FeedMethod,
    ) -> Result<Self, Failure> {
        let name = PathBuf::from("table");
        let faults = |faults: Diagnostics| Failure::faults(&name, &faults);
        let header =
            TableHeader::parse(1, &table.names.join(",")).map_err(|fault| faults(fault.into()))?;
        let names = columns(&header, limits, method).map_err(faults)?;
        let wanted: Vec<&str> = names.iter().map(String::as_str).collect();
        header.columns(&wanted).map_err(faults)?;
        let at = |name: &String| table.names.iter().position(|known| known == name).unwrap_or(0);
        let places: Vec<usize> = names.iter().map(at).collect();
        let rows = table.values.chunks_exact(table.names.len().max(1));
        let values = rows.clone().flat_map(|row| places.iter().map(|&at| row[at])).collect();
        let lines = (1..).take(rows.len()).collect();
        let layout = Layout::new(&names, limits);
        Ok(Self { name, rows: Rows { names, lines, values }, layout })
    }

    /// Returns the path, or all faults of its rows.
    pub(super) fn path<const N: usize>(
        &self,
        limits: &Limits<N>,
        args: &FeedArgs,
    ) -> Result<AxisPath<N>, Failure> {
        let mut faults = Faults::default();
        if self.rows.lines.len() < 2 {
            faults.add(Diagnostic::whole("a path needs at least two rows"));
        }
        let path = AxisPath { pieces: self.pieces(&mut faults) };
        // Quintics through faulty rows would only report the same faults again.
        if faults.is_empty() {
            self.thirds(&path, limits, args, &mut faults);
        }
        if faults.is_empty() {
            Ok(path)
        } else {
            Err(Failure::faults(&self.name, &faults.listed()))
        }
    }

    /// Splits the rows into pieces at repeated values of s.
    fn pieces<const N: usize>(&self, faults: &mut Faults) -> Vec<AxisPiece<N>> {
        let mut pieces = Vec::new();
        // Most paths are one piece; growing would move them several times.
        let mut nodes: Vec<AxisNode<N>> = Vec::with_capacity(self.rows.lines.len());
        let width = self.rows.names.len();
        let rows = self.rows.lines.iter().zip(self.rows.values.chunks(width));
        for (row, (line, values)) in rows.enumerate() {
            let node = self.layout.node(*line, values, faults);
            if let Some(before) = nodes.last() {
                // A jump needs a piece of two rows before it, and a row after it.
                let inside = nodes.len() >= 2 && row + 1 < self.rows.lines.len();
                let position = if inside { JumpPosition::Inside } else { JumpPosition::AtEnd };
                if self.layout.next(*line, [before, &node], position, faults) == Next::Piece {
                    pieces.push(piece(std::mem::take(&mut nodes)));
                }
            }
            nodes.push(node);
        }
        pieces.push(piece(nodes));
        pieces
    }

    /// Returns the column `speed`, piece by piece.
    pub(super) fn speeds<const N: usize>(&self, path: &AxisPath<N>) -> Vec<GivenSpeed> {
        let width = self.rows.names.len();
        let mut speeds = self.rows.values.chunks(width).map(|row| row.last().copied());
        let of = |piece: &AxisPiece<N>| GivenSpeed {
            s: piece.nodes.iter().map(|node| node.s).collect(),
            speed: speeds.by_ref().take(piece.nodes.len()).flatten().collect(),
        };
        path.pieces.iter().map(of).collect()
    }

    /// Compares NAME3 with the third derivatives of the quintics on both sides of every row.
    fn thirds<const N: usize>(
        &self,
        path: &AxisPath<N>,
        limits: &Limits<N>,
        args: &FeedArgs,
        faults: &mut Faults,
    ) {
        let tolerance = ThirdTolerance { limits, method: args.method, share: args.third_tolerance };
        for axis in self.layout.thirds() {
            let nodes = path.pieces.iter().flat_map(|piece| &piece.nodes);
            let largest = nodes.fold(0.0_f64, |most, node| most.max(node.q[3][axis].abs()));
            let mut lines = self.rows.lines.as_slice();
            for piece in &path.pieces {
                let (own, rest) = lines.split_at(piece.nodes.len().min(lines.len()));
                for (index, lines) in own.windows(2).enumerate() {
                    let interval = PieceInterval { lines: [lines[0], lines[1]], piece, index };
                    self.layout.third(&interval, axis, largest, &tolerance, faults);
                }
                lines = rest;
            }
        }
    }

    /// Returns the rests of the axes inside the path.
    pub(super) fn rests<const N: usize>(&self, path: &AxisPath<N>) -> Vec<Rest> {
        let mut row = 0;
        let mut rests = Vec::new();
        for pair in path.pieces.windows(2) {
            row += pair[0].nodes.len();
            let (Some(before), Some(after)) = (pair[0].nodes.last(), pair[1].nodes.first()) else {
                continue;
            };
            let line = self.rows.lines.get(row).copied().unwrap_or(0);
            rests.push(Rest { s: after.s, line, jump: self.layout.jump([before, after]) });
        }
        rests
    }
}

fn piece<const N: usize>(nodes: Vec<AxisNode<N>>) -> AxisPiece<N> {
    AxisPiece { motion: Motion::Cut, source: 0, nodes }
}
