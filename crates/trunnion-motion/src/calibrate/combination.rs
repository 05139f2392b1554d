//! Combinations that the readings do not separate, with as few parts as possible.

use super::model::{ChainModel, Deviations};
use super::report::{CombinationPart, DeviationCombination};

/// Share of the largest part below which a part is left out of the words.
const NEGLIGIBLE: f64 = 0.02;

/// Turns a basis of scaled directions into combinations: reduced row by row, so that each has a deviation of its own.
pub(super) fn combinations(
    basis: &[Deviations],
    scale: &Deviations,
    model: &ChainModel,
) -> Vec<DeviationCombination> {
    let mut rows = basis.to_vec();
    for row in 0..rows.len() {
        let Some(pivot) = rows.get(row).map(nalgebra::Matrix::icamax) else { break };
        let Some(own) = rows.get(row).copied().filter(|own| own[pivot].abs() > 0.0) else {
            continue;
        };
        for (index, other) in rows.iter_mut().enumerate() {
            if index == row {
                *other = own / own[pivot];
            } else {
                *other -= own * (other[pivot] / own[pivot]);
            }
        }
    }
    rows.iter().map(|row| combination(row, scale, model)).collect()
}

fn combination(row: &Deviations, scale: &Deviations, model: &ChainModel) -> DeviationCombination {
    let least = NEGLIGIBLE * row.amax();
    let mut order: Vec<usize> = (0..row.len()).filter(|&index| row[index].abs() > least).collect();
    order.sort_by(|&a, &b| row[b].abs().total_cmp(&row[a].abs()));
    let part = |index: usize| {
        let deviation = *model.deviations.get(index)?;
        Some(CombinationPart { deviation, change: row[index] * scale[index] })
    };
    DeviationCombination { parts: order.into_iter().filter_map(part).collect() }
}
