//! Cells of a face that the machine reaches at no inclination. No passes are placed there.

use crate::cover::cost::PassCost;
use crate::cover::layout::cell_grid::CellGrid;
use crate::cover::place::tool_fit::{self, ContactPoint};
use crate::cover::prove::face_tree::edge;
use crate::cutter::Cutter;
use crate::surface::FaceIndex;
use rayon::prelude::*;

/// Cells each way of the grid.
const CELLS: usize = 64;

/// Finds the cells of a face without reach at all their corners; `None` where there are none.
///
/// A pose that is inclined a little more than any tool would be counts as reached. So a cell that is left out holds
/// nothing that a pass could finish, but for slivers far smaller than a cell.
pub(crate) fn unreachable_cells(
    face: &FaceIndex,
    cutter: &Cutter,
    cost: &dyn PassCost,
) -> Option<CellGrid> {
    let bounds = face.face().bounds();
    let line = |k: usize, i: usize| edge(bounds[k].ends(), i as f64 / CELLS as f64);
    let wide = CELLS + 1;
    let out: Vec<bool> = (0..wide * wide)
        .into_par_iter()
        .map(|i| {
            let contact = ContactPoint::new(face, [line(0, i / wide), line(1, i % wide)]);
            contact.is_some_and(|contact| !tool_fit::reached(cost, &contact, cutter))
        })
        .collect();
    let at = |i: usize, j: usize| out.get(i * wide + j).copied().unwrap_or(true);
    CellGrid::new(face, [CELLS; 2], |[i, j]| {
        [at(i, j), at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)].iter().all(|out| *out)
    })
}
