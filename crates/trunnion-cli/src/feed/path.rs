//! A table of axis positions and derivatives as an axis path.

use super::args::{FeedArgs, FeedMethod};
use super::layout::{JumpPosition, Layout, Next, PieceInterval, ThirdTolerance, columns};
use super::run::{AxisColumn, AxisTable};
use crate::outcome::Failure;
use crate::table::{Ends, Faults};
use std::path::PathBuf;
use trunnion::feed::{GivenSpeed, Limits};
use trunnion::files::limits::LimitsFile;
use trunnion::files::table::TableHeader;
use trunnion::types::{AxisNode, AxisPath, AxisPiece, Diagnostic, Diagnostics, Motion};

/// Table and the meaning of its columns. Its numbers become a path at once, and are not kept.
pub(super) struct Table {
    name: PathBuf,
    /// Line of each row.
    lines: Vec<u32>,
    /// Column `speed`; empty where the method does not read it.
    speeds: Vec<f64>,
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
    /// Reads a table, and hands it on with its numbers. Its axes are those of the limits file; others have no limits,
    /// which is a fault.
    pub(super) fn read<T>(
        ends: &Ends,
        limits: &LimitsFile,
        method: FeedMethod,
        with: impl FnOnce(&Self, &TableNumbers<'_>) -> Result<T, Failure>,
    ) -> Result<T, Failure> {
        let rows = ends.read(|header| columns(header, limits, method))?;
        let step = rows.names.len();
        let column = |at| AxisColumn { values: rows.values.get(at..).unwrap_or_default(), step };
        let numbers = TableNumbers((0..step).map(column).collect());
        let layout = Layout::new(&rows.names, limits);
        let speeds = numbers.speeds(method);
        with(&Self { name: ends.name().to_owned(), lines: rows.lines, speeds, layout }, &numbers)
    }

    /// Takes the columns of a table in memory; rows count from 1.
    pub(super) fn of_columns<'a>(
        table: AxisTable<'a>,
        limits: &LimitsFile,
        method: FeedMethod,
    ) -> Result<(Self, TableNumbers<'a>), Failure> {
        let name = PathBuf::from("table");
        let faults = |faults: Diagnostics| Failure::faults(&name, &faults);
        let header =
            TableHeader::parse(1, &table.names.join(",")).map_err(|fault| faults(fault.into()))?;
        let names = columns(&header, limits, method).map_err(faults)?;
        let wanted: Vec<&str> = names.iter().map(String::as_str).collect();
        header.columns(&wanted).map_err(faults)?;
        let known = || table.names.iter().zip(table.columns);
        let column = |name: &String| known().find(|(known, _)| *known == name);
        let found = names.iter().filter_map(column).map(|(_, column)| *column);
        let numbers = TableNumbers(found.collect());
        let lines = (1..).take(numbers.rows()).collect();
        let layout = Layout::new(&names, limits);
        let speeds = numbers.speeds(method);
        Ok((Self { name, lines, speeds, layout }, numbers))
    }

    /// Returns the path, or all faults of its rows.
    pub(super) fn path<const N: usize>(
        &self,
        numbers: &TableNumbers<'_>,
        limits: &Limits<N>,
        args: &FeedArgs,
    ) -> Result<AxisPath<N>, Failure> {
        let mut faults = Faults::default();
        if self.lines.len() < 2 {
            faults.add(
                Diagnostic::whole("a path needs at least two rows").with_help("add its other rows"),
            );
        }
        let path = AxisPath { pieces: self.pieces(numbers, &mut faults) };
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
    fn pieces<const N: usize>(
        &self,
        numbers: &TableNumbers<'_>,
        faults: &mut Faults,
    ) -> Vec<AxisPiece<N>> {
        let mut pieces = Vec::new();
        // Most paths are one piece; growing would move them several times.
        let mut nodes: Vec<AxisNode<N>> = Vec::with_capacity(self.lines.len());
        for (row, line) in self.lines.iter().enumerate() {
            let node = self.layout.node(*line, numbers.row(row), faults);
            if let Some(before) = nodes.last() {
                // A jump needs a piece of two rows before it, and a row after it.
                let inside = nodes.len() >= 2 && row + 1 < self.lines.len();
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
        let mut speeds = self.speeds.iter().copied();
        let of = |piece: &AxisPiece<N>| GivenSpeed {
            s: piece.nodes.iter().map(|node| node.s).collect(),
            speed: speeds.by_ref().take(piece.nodes.len()).collect(),
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
            let mut lines = self.lines.as_slice();
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
            let line = self.lines.get(row).copied().unwrap_or(0);
            rests.push(Rest { s: after.s, line, jump: self.layout.jump([before, after]) });
        }
        rests
    }
}

/// Columns of a table that are read, in the order of [`columns`].
pub(super) struct TableNumbers<'a>(Vec<AxisColumn<'a>>);

impl TableNumbers<'_> {
    /// Returns the number of rows that all columns have.
    fn rows(&self) -> usize {
        self.0.iter().map(AxisColumn::len).min().unwrap_or(0)
    }

    /// Returns the numbers of a row.
    #[inline]
    fn row(&self, row: usize) -> impl Iterator<Item = f64> {
        self.0.iter().map(move |column| column.at(row))
    }

    /// Returns the column `speed`, which is the last one of given speeds.
    fn speeds(&self, method: FeedMethod) -> Vec<f64> {
        let last = self.0.last().filter(|_| method == FeedMethod::Given);
        last.map_or(Vec::new(), |column| (0..column.len()).map(|row| column.at(row)).collect())
    }
}

fn piece<const N: usize>(nodes: Vec<AxisNode<N>>) -> AxisPiece<N> {
    AxisPiece { motion: Motion::Cut, source: 0, nodes }
}
