//! Deviations along a path of any length, in a fixed number of bins.

use trunnion::toolpath::PathDeviation;

/// Most bins; between half of it and all are in use, more than a drawing has columns.
const MOST: usize = 4096;

/// Largest deviations by distance along a path.
#[derive(Debug, Clone, Default)]
pub(crate) struct Profile {
    bins: Vec<PathDeviation>,
    /// Length of a bin \[mm\].
    width: f64,
    length: f64,
}

impl Profile {
    /// Adds the deviation from the end of the last stretch to `end` \[mm\].
    pub(crate) fn push(&mut self, end: f64, deviated: &PathDeviation) {
        if end.is_nan() || end <= self.length {
            return;
        }
        if self.bins.is_empty() {
            // The first stretch fills half of the bins: from then on, at least half are in use.
            self.width = 2.0 * end / MOST as f64;
        }
        // A path that outgrows the bins halves them in pairs: the largest value of each pair stays.
        while end > self.width * MOST as f64 {
            self.bins = self.bins.chunks(2).map(worst).collect();
            self.width *= 2.0;
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a bin")]
        let [first, last] = [self.length, end].map(|at| ((at / self.width) as usize).min(MOST - 1));
        if self.bins.len() <= last {
            self.bins.resize(last + 1, PathDeviation::default());
        }
        for bin in &mut self.bins[first..=last] {
            *bin = bin.worst(deviated);
        }
        self.length = end;
    }

    /// Returns the length of the path \[mm\].
    pub(crate) fn length(&self) -> f64 {
        self.length
    }

    /// Returns the largest values of `of` in each of `count` equal stretches of the path.
    pub(crate) fn columns(
        &self,
        count: usize,
        of: impl Fn(&PathDeviation) -> [f64; 2],
    ) -> Vec<[f64; 2]> {
        let mut columns = vec![[0.0_f64; 2]; count];
        if self.bins.is_empty() || count == 0 {
            return columns;
        }
        // A bin may cover two columns; both take its largest value, so that no peak is lost.
        let share = self.width / self.length * count as f64;
        for (index, bin) in self.bins.iter().enumerate() {
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a column")]
            let column = |at: usize| ((at as f64 * share) as usize).min(count - 1);
            let values = of(bin);
            for slot in &mut columns[column(index)..=column(index + 1)] {
                *slot = [slot[0].max(values[0]), slot[1].max(values[1])];
            }
        }
        columns
    }
}

fn worst(bins: &[PathDeviation]) -> PathDeviation {
    bins.iter().fold(PathDeviation::default(), |worst, bin| worst.worst(bin))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_large_is_lost_however_long_the_path() {
        let mut profile = Profile::default();
        for k in 1..=100_000_u32 {
            let tip = if k == 70_000 { 1.0 } else { 0.1 };
            let mut deviation = PathDeviation::default();
            deviation.tip = tip;
            profile.push(0.3 * f64::from(k), &deviation);
        }
        assert!(profile.bins.len() <= MOST && profile.bins.len() > MOST / 4);
        let columns = profile.columns(100, |of| [of.tip, 0.0]);
        let high: Vec<usize> = (0..100).filter(|&k| columns[k][0] > 0.5).collect();
        assert!(high.contains(&69) || high.contains(&70), "{high:?}");
        assert!(high.len() <= 2 && columns.iter().all(|column| column[0] >= 0.1));
    }
}
