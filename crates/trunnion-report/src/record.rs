//! Reduction of many samples to few time slots, without losing a peak.

use crate::data::{Axis, AxisBands, Band, Histogram, Motion, Surface, SurfacePoint};

/// Machine at one moment, in the units of its axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample<'a> {
    /// Time \[s\].
    pub t: f64,
    /// Position of each axis \[unit\].
    pub position: &'a [f64],
    /// Velocity of each axis \[unit/s\].
    pub velocity: &'a [f64],
    /// Acceleration of each axis \[unit/s²\].
    pub acceleration: &'a [f64],
    /// Jerk of each axis \[unit/s³\].
    pub jerk: &'a [f64],
    /// Speed of the programmed point \[mm/s\].
    pub speed: f64,
    /// Speed of the tool tip \[mm/s\].
    pub tip: f64,
    /// True if the programmed feed applies, which it does not on links.
    pub cutting: bool,
}

/// Fraction of a limit from which it counts as reached. Only a label in a chart depends on it.
const REACHED: f64 = 0.98;

/// Gathers samples into a [`Motion`] of a given number of slots.
#[derive(Debug, Clone)]
pub struct Recorder {
    motion: Motion,
    nearest: Vec<f64>,
}

impl Recorder {
    /// Starts a record of `duration` \[s\] in `slots` slots; `feed` is the programmed one \[mm/s\].
    pub fn new(axes: Vec<Axis>, duration: f64, slots: usize, feed: f64) -> Self {
        let empty =
            || Band { min: vec![f64::INFINITY; slots], max: vec![f64::NEG_INFINITY; slots] };
        let bands = axes
            .iter()
            .map(|_| AxisBands {
                position: empty(),
                velocity: empty(),
                acceleration: empty(),
                jerk: empty(),
            })
            .collect();
        let binding = vec![0; slots];
        let (speed, tip) = (empty(), empty());
        let motion = Motion { duration, axes, bands, speed, tip, feed, binding };
        Self { motion, nearest: vec![REACHED; slots] }
    }

    /// Adds a sample; one outside the duration counts to the nearest slot.
    pub fn add(&mut self, sample: &Sample<'_>) {
        let slots = self.nearest.len();
        let Some(last) = slots.checked_sub(1) else { return };
        let share = sample.t / self.motion.duration.max(f64::MIN_POSITIVE);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "the cast saturates, and the slot is clamped"
        )]
        let slot = ((share * slots as f64) as usize).min(last);
        let (limit, fraction) = self.binding_limit(sample);
        let rates = sample.velocity.iter().zip(sample.acceleration).zip(sample.jerk);
        let rows = sample.position.iter().zip(rates);
        for (bands, (&q, ((&v, &a), &j))) in self.motion.bands.iter_mut().zip(rows) {
            bands.position.include(slot, q);
            bands.velocity.include(slot, v);
            bands.acceleration.include(slot, a);
            bands.jerk.include(slot, j);
        }
        self.motion.speed.include(slot, sample.speed);
        self.motion.tip.include(slot, sample.tip);
        if let (Some(nearest), Some(binding)) =
            (self.nearest.get_mut(slot), self.motion.binding.get_mut(slot))
            // The largest fraction of the slot wins, so that a short peak keeps its label.
            && fraction > *nearest
        {
            *nearest = fraction;
            *binding = limit;
        }
    }

    /// Returns the record; slots without a sample repeat the one before.
    pub fn finish(mut self) -> Motion {
        for bands in &mut self.motion.bands {
            bands.position.fill();
            bands.velocity.fill();
            bands.acceleration.fill();
            bands.jerk.fill();
        }
        self.motion.speed.fill();
        self.motion.tip.fill();
        self.motion
    }

    /// Returns the limit that a sample is nearest to, numbered as in [`Motion::binding`], and the fraction reached.
    fn binding_limit(&self, sample: &Sample<'_>) -> (u8, f64) {
        let mut worst = (0, 0.0);
        // A limit of 0 is none: 0 for jerk in plans without jerk limits.
        let mut consider = |limit: usize, value: f64, of: f64| {
            let fraction = value.abs() / of;
            if of > 0.0 && fraction > worst.1 {
                worst = (u8::try_from(limit).unwrap_or(0), fraction);
            }
        };
        if sample.cutting {
            consider(1, sample.speed, self.motion.feed);
        }
        let rows = sample.velocity.iter().zip(sample.acceleration).zip(sample.jerk);
        for (index, (axis, ((&v, &a), &j))) in self.motion.axes.iter().zip(rows).enumerate() {
            consider(2 + 3 * index, v, axis.velocity);
            consider(3 + 3 * index, a, axis.acceleration);
            consider(4 + 3 * index, j, axis.jerk);
        }
        worst
    }
}

impl Band {
    fn include(&mut self, slot: usize, value: f64) {
        if let Some(min) = self.min.get_mut(slot) {
            *min = min.min(value);
        }
        if let Some(max) = self.max.get_mut(slot) {
            *max = max.max(value);
        }
    }

    fn fill(&mut self) {
        let mut last = (0.0, 0.0);
        for (min, max) in self.min.iter_mut().zip(&mut self.max) {
            if min.is_finite() && max.is_finite() {
                last = (*min, *max);
            } else {
                (*min, *max) = last;
            }
        }
    }
}

impl Histogram {
    /// Counts deviations \[mm\] in `bins` bins from `start` to `end`; those beyond count to the end
    /// bins.
    ///
    /// # Example
    ///
    /// ```
    /// use trunnion_report::Histogram;
    ///
    /// let histogram = Histogram::of([-1.0, 0.1, 0.2, 7.0], [0.0, 2.0], 2);
    /// assert_eq!(histogram.counts, [3, 1]);
    /// ```
    pub fn of(
        deviations: impl IntoIterator<Item = f64>,
        [start, end]: [f64; 2],
        bins: usize,
    ) -> Self {
        let width = (end - start) / bins.max(1) as f64;
        let mut counts = vec![0; bins];
        for value in deviations.into_iter().filter(|value| value.is_finite()) {
            // The end bins collect what lies beyond: no point is lost.
            let bin = ((value - start) / width).clamp(0.0, bins.saturating_sub(1) as f64);
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "clamped to the bins above"
            )]
            if let Some(count) = counts.get_mut(bin as usize) {
                *count += 1;
            }
        }
        Self { start, width, counts }
    }
}

impl Surface {
    /// Adds a grid of `columns` vertices a row; cells with a missing corner are left open.
    ///
    /// Points off the face are `None`.
    pub fn add_grid(&mut self, columns: usize, points: &[Option<SurfacePoint>]) {
        let index: Vec<Option<u32>> = points
            .iter()
            .map(|point| {
                let SurfacePoint { position, deviation } = (*point)?;
                let number = u32::try_from(self.vertices.len()).ok()?;
                self.vertices.push(position);
                self.deviation.push(deviation);
                Some(number)
            })
            .collect();
        // A row of the grid has `columns` points; each cell is split along one diagonal.
        let rows: Vec<&[Option<u32>]> = index.chunks_exact(columns.max(1)).collect();
        for pair in rows.windows(2) {
            let &[low, high] = pair else { continue };
            for (a, b) in low.windows(2).zip(high.windows(2)) {
                let (&[a0, a1], &[b0, b1]) = (a, b) else { continue };
                self.triangles.extend(triangle([a0, a1, b1]));
                self.triangles.extend(triangle([a0, b1, b0]));
            }
        }
    }
}

fn triangle(corners: [Option<u32>; 3]) -> Option<[u32; 3]> {
    let [a, b, c] = corners;
    Some([a?, b?, c?])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axis(name: &str) -> Axis {
        let (velocity, acceleration, jerk) = (10.0, 100.0, 1000.0);
        Axis { name: name.into(), velocity, acceleration, jerk, ..Axis::default() }
    }

    #[test]
    fn a_peak_between_slots_survives_and_names_its_limit() {
        let mut recorder = Recorder::new(vec![axis("X"), axis("C")], 1.0, 4, 50.0);
        for step in 0..=1000 {
            let t = f64::from(step) / 1000.0;
            let v = if step == 333 { -9.9 } else { 1.0 };
            let sample = Sample {
                t,
                position: &[t, 2.0],
                velocity: &[0.0, v],
                acceleration: &[0.0, 0.0],
                jerk: &[0.0, if step == 600 { 995.0 } else { 10.0 }],
                tip: 7.0,
                speed: if step > 900 { 50.0 } else { 5.0 },
                cutting: true,
            };
            recorder.add(&sample);
        }
        let motion = recorder.finish();
        assert_eq!(motion.binding, [0, 5, 7, 1]);
        assert_eq!(motion.bands[1].velocity.min, [1.0, -9.9, 1.0, 1.0]);
        assert_eq!(motion.bands[1].jerk.max, [10.0, 10.0, 995.0, 10.0]);
        assert_eq!(motion.tip.min, [7.0; 4]);
        assert_eq!(motion.bands[0].position.max.last(), Some(&1.0));
    }

    #[test]
    fn a_histogram_loses_no_point() {
        let histogram = Histogram::of([-9.0, 0.0, 0.5, 1.9, 7.0, f64::NAN], [0.0, 2.0], 4);
        assert_eq!(histogram.counts, [2, 1, 0, 2]);
    }

    #[test]
    fn a_grid_with_a_hole_has_no_triangle_over_it() {
        let at =
            |x: f64, y: f64| Some(SurfacePoint { position: [x, y, 0.0], deviation: Some(0.0) });
        let mut surface = Surface::default();
        surface.add_grid(3, &[at(0., 0.), at(1., 0.), at(2., 0.), at(0., 1.), at(1., 1.), None]);
        assert_eq!(surface.triangles, [[0, 1, 4], [0, 4, 3]]);
    }
}
