//! Choice of other inclinations along a candidate pass, where the tool cannot take the one that was
//! asked for.
//!
//! Every inclination is relative to the face's normal and the feed, so that the tool turns as the
//! face does. Where no inclination serves a whole pass, the tool is lifted between segments of
//! different inclinations, as few as possible.

use crate::cover::place::candidate::{CandidatePass, LocationResult, PlacedStation};
use crate::cutter::TangentProfile;
use crate::math;
use crate::positioning::{ActiveConstraint, PositioningError, ToolInclination};
use rayon::prelude::*;
use std::f64::consts::{FRAC_PI_2, TAU};

/// Approximate number of stations at which all inclinations are tried.
const TRIED: usize = 16;

/// Largest number of inclinations that are tried at all stations.
const CHOSEN: usize = 5;

/// Angles from the normal that are tried, and directions \[rad\]: all round for a ball, on either
/// side of the feed for other cutters.
const BALL_ANGLES: [f64; 6] = [0.2, 0.45, 0.7, 1.0, 1.3, 1.5];
const BALL_DIRECTIONS: u32 = 8;
const ANGLES: [f64; 5] = [0.0, 0.01, 0.09, 0.25, 0.5];
const DIRECTIONS: [f64; 5] = [0.0, 0.8, -0.8, 1.4, -1.4];

/// Shares of the arc of a barrel with which it is tried.
const BARREL_SHARES: [f64; 3] = [0.5, 0.2, 0.8];

/// Costs by which inclinations are chosen: per radian of difference from the one asked for; of a
/// station before the track; of lifting the tool; of leaving a station out.
const DIFFERENT: f64 = 0.1;
const BACK: f64 = 1.0;
const LIFT: f64 = 10.0;
const LEFT_OUT: f64 = 100.0;

/// Stations of a pass at one inclination.
struct InclinedRow {
    lean: ToolInclination,
    places: Vec<LocationResult>,
}

impl CandidatePass<'_> {
    /// Returns the inclinations to try, without the one asked for.
    fn leans(&self) -> Vec<ToolInclination> {
        if self.cutter.is_barrel() {
            return self.barrel_leans();
        }
        if !self.cutter.touches_in_one_point() {
            let upright = |lean: &ToolInclination| lean.angle <= 0.0 && lean.towards != Some(0.0);
            let of = |angle: f64| {
                DIRECTIONS.map(move |towards| ToolInclination { angle, towards: Some(towards) })
            };
            let leans = ANGLES.into_iter().flat_map(of);
            return leans.filter(|lean| !upright(lean)).collect();
        }
        let of = |angle: f64| {
            (0..BALL_DIRECTIONS).map(move |i| {
                let towards = TAU * f64::from(i) / f64::from(BALL_DIRECTIONS);
                ToolInclination { angle, towards: Some(towards) }
            })
        };
        // A side ends the ball of the tip: farther inclined, the contact would be off its arc.
        let most = self.cutter.tangent_profile().map_or(TAU, TangentProfile::tip_angle);
        BALL_ANGLES.into_iter().filter(|angle| *angle < most).flat_map(of).collect()
    }

    /// Returns the inclinations of a barrel: all over its arc, square to the feed, where the arc lies across it.
    fn barrel_leans(&self) -> Vec<ToolInclination> {
        let arc = self.cutter.contact_arc();
        let of = |share: f64| {
            [FRAC_PI_2, -FRAC_PI_2].map(|towards| ToolInclination {
                angle: arc.inclinations.at(share),
                towards: Some(towards),
            })
        };
        BARREL_SHARES.into_iter().flat_map(of).collect()
    }

    /// Returns `true` if another inclination may do better at a station.
    fn may_lean(&self, arc: f64, place: &LocationResult) -> bool {
        let whole = |place: &LocationResult| place.as_ref().is_ok_and(|p| p.across >= self.across);
        // The corner has to fit at the track and half a narrow strip beyond it: otherwise no
        // inclination helps.
        let ahead = 0.5 * self.costs().narrow / self.rate_across();
        let along = self.track.at(arc);
        !whole(place)
            && [0.0, ahead].iter().all(|by| self.corner_fits([self.across + by, along]).is_ok())
    }

    /// Places the stations by inclination, for `wanted` stations that have no location at the
    /// inclination asked for, or none on the track.
    pub(crate) fn inclined_stations(
        &self,
        arcs: &[f64],
        places: Vec<LocationResult>,
        wanted: &[bool],
    ) -> Vec<Vec<LocationResult>> {
        let bad: Vec<usize> = (0..arcs.len())
            .into_par_iter()
            .filter(|&i| wanted[i] && self.may_lean(arcs[i], &places[i]))
            .collect();
        if bad.is_empty() {
            return vec![places];
        }
        let chosen = self.chosen(arcs, &bad);
        let others = chosen
            .into_iter()
            .map(|lean| InclinedRow { lean, places: self.leaning(arcs, lean, &bad) });
        let mut all = vec![InclinedRow { lean: self.lean(), places }];
        all.extend(others);
        let choice = self.best(&all, wanted);
        all.into_iter()
            .enumerate()
            .filter(|(which, _)| choice.contains(&Some(*which)))
            .map(|(which, row)| taken(row.places, which, &choice))
            .collect()
    }

    /// Places stations at one inclination. They lie before the track only where the inclination
    /// asked for fails, and only next to stations that are served: on from there as far as
    /// locations are found.
    fn leaning(&self, arcs: &[f64], lean: ToolInclination, bad: &[usize]) -> Vec<LocationResult> {
        let mut places: Vec<LocationResult> =
            arcs.par_iter().map(|arc| self.here(*arc, lean)).collect();
        let orders: [&mut dyn Iterator<Item = usize>; 2] =
            [&mut (0..arcs.len()), &mut (0..arcs.len()).rev()];
        for order in orders {
            let mut served = false;
            for i in order {
                if places[i].is_err() && served && bad.binary_search(&i).is_ok() {
                    places[i] = self.place_alone(arcs[i], lean);
                }
                served = places[i].is_ok();
            }
        }
        places
    }

    /// Chooses inclinations greedily: one after the other, the one that serves most of the stations
    /// that are still open.
    fn chosen(&self, arcs: &[f64], bad: &[usize]) -> Vec<ToolInclination> {
        let step = bad.len().div_ceil(TRIED);
        let tried: Vec<f64> = bad.iter().step_by(step).map(|&i| arcs[i]).collect();
        let serves: Vec<(ToolInclination, Vec<bool>)> = self
            .leans()
            .into_par_iter()
            .map(|lean| (lean, tried.iter().map(|arc| self.serves(*arc, lean)).collect()))
            .collect();
        let mut open = vec![true; tried.len()];
        let mut chosen = Vec::new();
        while chosen.len() < CHOSEN {
            let gain = |(_, serves): &&(ToolInclination, Vec<bool>)| {
                serves.iter().zip(&open).filter(|(a, b)| **a && **b).count()
            };
            // Of equal ones the last: the search goes from the last to the first.
            let best = serves.iter().rev().max_by_key(gain);
            let Some((lean, serves)) = best.filter(|one| gain(one) > 0) else { break };
            open.iter_mut().zip(serves).for_each(|(open, serves)| *open &= !serves);
            chosen.push(*lean);
        }
        chosen
    }

    /// Returns the inclination for each station, `None` for none: the cheapest path through all of
    /// them, by dynamic programming.
    fn best(&self, all: &[InclinedRow], wanted: &[bool]) -> Vec<Option<usize>> {
        let none = all.len();
        let cost = |which: usize, i: usize| {
            let Some(InclinedRow { lean, places }) = all.get(which) else {
                return if wanted[i] { LEFT_OUT } else { 0.0 };
            };
            // Near the inclination asked for, on the track, and without lifting: in this order of
            // weight, from the least to the greatest.
            let different = DIFFERENT * angle(*lean, self.lean());
            match &places[i] {
                Err(_) => f64::INFINITY,
                Ok(placed) if placed.across < self.across => different + BACK,
                Ok(_) => different,
            }
        };
        // Least cost up to each station, by the inclination there; `before` remembers the best
        // predecessor.
        let mut sums: Vec<f64> = (0..=none).map(|which| cost(which, 0)).collect();
        let mut before: Vec<Vec<usize>> = Vec::new();
        for i in 1..wanted.len() {
            let from = |which: usize| {
                let price = |old: usize| {
                    let lift = if old == which { 0.0 } else { LIFT };
                    sums[old] + lift
                };
                (0..=none)
                    .min_by(|a, b| price(*a).total_cmp(&price(*b)))
                    .map(|old| (old, price(old)))
            };
            let steps: Vec<(usize, f64)> =
                (0..=none).map(|which| from(which).unwrap_or((which, f64::INFINITY))).collect();
            sums = steps.iter().enumerate().map(|(w, (_, sum))| sum + cost(w, i)).collect();
            before.push(steps.into_iter().map(|(old, _)| old).collect());
        }
        let last = (0..=none).min_by(|a, b| sums[*a].total_cmp(&sums[*b])).unwrap_or(none);
        let mut choice = vec![last];
        for step in before.iter().rev() {
            choice.push(choice.last().and_then(|which| step.get(*which)).copied().unwrap_or(none));
        }
        // Followed back from the cheapest end, so in reverse order.
        choice.reverse();
        choice.into_iter().map(|which| (which < none).then_some(which)).collect()
    }
}

/// Returns the approximate angle between two inclinations \[rad\].
fn angle(a: ToolInclination, b: ToolInclination) -> f64 {
    // Inclinations as points of the plane, in polar coordinates: for small angles their distance is
    // the angle between the axes.
    let place = |lean: ToolInclination| {
        let (sin, cos) = math::sin_cos(lean.towards.unwrap_or(0.0));
        [lean.angle * cos, lean.angle * sin]
    };
    let ([x, y], [z, w]) = (place(a), place(b));
    math::hypot(x - z, y - w)
}

/// Keeps the stations where an inclination is taken, and one more at either end, so that nothing
/// stays uncut between two inclinations.
fn taken(
    places: Vec<LocationResult>,
    which: usize,
    choice: &[Option<usize>],
) -> Vec<LocationResult> {
    let is = |i: usize| choice.get(i) == Some(&Some(which));
    let near = |i: usize| is(i) || is(i + 1) || i.checked_sub(1).is_some_and(is);
    let keep = |(i, place): (usize, LocationResult)| match place {
        Ok(placed) if !near(i) => Err(other_lean(&placed)),
        place => place,
    };
    places.into_iter().enumerate().map(keep).collect()
}

/// Returns the error of a station that is placed at another inclination.
fn other_lean(placed: &PlacedStation) -> PositioningError {
    PositioningError::NoStrip {
        uv: placed.location.end,
        smallest: placed.location.strip_width,
        excess: 0.0,
        binding: ActiveConstraint::GivenLead,
    }
}
