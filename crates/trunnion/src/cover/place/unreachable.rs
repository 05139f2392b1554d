//! Cells of a face that no pass finishes: the machine reaches no inclination at which the tool keeps off all faces, or the
//! corner of the cutter is barred by others. No passes are placed there.

use crate::cover::layout::advance::ball_strip_width;
use crate::cover::layout::cell_grid::CellGrid;
use crate::cover::options::CoverOptions;
use crate::cover::place::barred::barred_cells;
use crate::cover::place::context::PartSetup;
use crate::cover::place::tool_fit::{self, ContactPoint};
use crate::cover::prove::face_cell::FaceCell;
use crate::cover::prove::face_tree::edge;
use crate::cover::prove::part_faces::KeepOff;
use crate::cutter::ToolBody;
use crate::surface::FaceIndex;
use crate::types::Interval;
use rayon::prelude::*;

/// Size of a cell, in widths of a narrow strip.
const SIZE: f64 = 2.0;

/// Fewest and most cells each way of the grid.
const CELLS: [usize; 2] = [8, 64];

/// Finds the cells of a face that are barred, or without access at their own corners and those of the cells around them;
/// `None` where there are none.
///
/// At a corner of a cell some tens of poses are tried, inclined a little more than any tool would be, and a tool counts as
/// kept off that goes into a face by less than the width of a narrow strip. Between corners other poses may fit at the
/// edge of an area without access, so its outermost cells stay in.
pub(crate) fn unreachable_cells(
    face: &FaceIndex,
    setup: &PartSetup<'_>,
    options: &CoverOptions,
) -> Option<CellGrid> {
    let bounds = face.face().bounds();
    let narrow = ball_strip_width(setup.cutter, options);
    let whole =
        FaceCell::new(bounds.map(Interval::ends), &|[u, v]: [f64; 2]| face.face().point(u, v));
    let counts = [0, 1].map(|k| {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
        let count = (whole.extent(k) / (SIZE * narrow)).ceil().min(CELLS[1] as f64) as usize;
        count.clamp(CELLS[0], CELLS[1])
    });
    let (PartSetup { cutter, part_faces, own, cost }, tool) = (*setup, ToolBody::new(setup.cutter));
    let (least, precision) = (options.band.lower - narrow, 0.5 * narrow);
    let deep = KeepOff { cost, part_faces, own, tool: &tool, least, precision };
    let line = |k: usize, i: usize| edge(bounds[k].ends(), i as f64 / counts[k] as f64);
    let wide = counts[1] + 1;
    let out: Vec<bool> = (0..(counts[0] + 1) * wide)
        .into_par_iter()
        .map(|i| {
            let contact = ContactPoint::new(face, [line(0, i / wide), line(1, i % wide)]);
            contact.is_some_and(|contact| !tool_fit::is_accessible(&deep, &contact, cutter))
        })
        .collect();
    // The corners of a cell and of the cells around it, as far as the face goes.
    let around = |k: usize, i: usize| i.saturating_sub(1)..=(i + 2).min(counts[k]);
    let is_out = |i: usize, j: usize| {
        around(0, i).all(|i| around(1, j).all(|j| out.get(i * wide + j).copied().unwrap_or(true)))
    };
    let barred = barred_cells(face, setup, options, counts);
    CellGrid::new(face, counts, |[i, j]| barred[i * counts[1] + j] || is_out(i, j))
}
