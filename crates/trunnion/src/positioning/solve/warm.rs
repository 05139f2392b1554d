//! Warm starts: climbs from the optimum of a neighbouring location.

use crate::positioning::distance::gaps::SPACING;
use crate::positioning::distance::gaps::curvatures_under;
use crate::positioning::distance::probe::FaceProbe;
use crate::positioning::error::PositioningError;
use crate::positioning::location::ExtremumMark;
use crate::positioning::solve::conditions::ExtremaSource;
use crate::positioning::solve::conditions::{ProblemState, StripCondition, StripProblem};
use crate::positioning::solve::initial_guesses::InitialGuess;
use crate::positioning::solve::optimum::LocalOptimum;

impl StripProblem {
    /// Climbs as [`StripProblem::climb`] does from a neighbour's optimum, whose extrema are followed: the
    /// `marks` it left, where they lead into the band, else those that sampling shows. Extrema that are
    /// new on the way go unnoticed.
    pub(crate) fn climb_following(
        &self,
        start: &InitialGuess,
        marks: &[ExtremumMark],
        arrived: f64,
        probe: &mut FaceProbe,
    ) -> Result<Option<LocalOptimum>, PositioningError> {
        let following = Self { extrema: ExtremaSource::Followed, ..*self };
        if !marks.is_empty()
            && let Some(state) = following.recalled(start.x, marks, probe)?
        {
            let optimum = following.ascend(state, start, arrived, probe)?;
            if optimum.state.breach() <= self.margin() {
                return Ok(Some(optimum));
            }
        }
        following.climb(start, arrived, probe)
    }

    /// Returns the end of a followed climb, with its samples, where bounds can prove that nothing was
    /// overlooked.
    pub(crate) fn proven(&self, optimum: &LocalOptimum, probe: &FaceProbe) -> Option<LocalOptimum> {
        let known = optimum.state.breach() <= self.margin() && self.is_known(&optimum.state, probe);
        known.then(|| {
            let state =
                ProblemState { samples: self.seen(&optimum.state), ..optimum.state.clone() };
            LocalOptimum { state, ..optimum.clone() }
        })
    }

    /// Samples the end of a followed climb all round. The second value is `true` if that shows nothing
    /// worse than what was followed; `None` where the cutter cannot be placed.
    pub(crate) fn sampled_all_round(
        &self,
        LocalOptimum { state, multipliers, at_range_end }: LocalOptimum,
        probe: &mut FaceProbe,
    ) -> Result<Option<(LocalOptimum, bool)>, PositioningError> {
        let following = Self { extrema: ExtremaSource::Followed, ..*self };
        let Some(last) = following.state(state.placement.x, probe, Some(&state))? else {
            return Ok(None);
        };
        let mut carried = vec![0.0; last.conditions.len()];
        for (condition, multiplier) in state.conditions.iter().zip(multipliers) {
            let alike = last.conditions.iter().zip(&mut carried);
            let alike = alike.filter(|(other, _)| other.kind == condition.kind);
            let apart = |other: &StripCondition| (other.psi - condition.psi).abs();
            let nearest = alike.min_by(|a, b| apart(a.0).total_cmp(&apart(b.0)));
            if let Some((_, carried)) = nearest {
                *carried += multiplier;
            }
        }
        // A tenth more may well be the same extremum, followed less closely.
        let foreseen = last.breach() <= 1.1 * state.breach();
        Ok(Some((LocalOptimum { state: last, multipliers: carried, at_range_end }, foreseen)))
    }

    /// Returns `true` if the curvatures around a state change at a bounded rate, so that a few readings of
    /// the circle prove as much as sampling it.
    fn is_known(&self, state: &ProblemState, probe: &FaceProbe) -> bool {
        let samples = state.conditions.iter().filter_map(|condition| condition.sample.as_ref());
        let ends = [&self.frame.first, &state.placement.second];
        let readings = ends.into_iter().chain(samples.map(|sample| &sample.reading));
        let way = 0.5 * SPACING * self.frame.major;
        curvatures_under(probe.face(), &readings, way, self.frame.lift + way).rate.is_finite()
    }
}
