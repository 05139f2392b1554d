//! The passes of a whole face: in which direction they run where, and how far each brings it on.

use super::ahead::Search;
use super::options::{CoverError, Method};
use super::region::Local;
use super::site::Site;
use super::state::State;
use super::task::{Job, Mark, Task};

/// Work, over that of passes at the fixed lead, after which these are given up as well: three times what they
/// should take.
const REST: f64 = 3.0;

/// Share of the progress that the first way through counts for, and that up to where rims are settled.
const FIRST: f64 = 0.25;
const RIMS: f64 = 0.5;

/// What passes on a rim have to cost, over a single pass across, to be worth another look.
const DEAR: f64 = 2.0;

/// Shares of the passes on a rim that begin no farther inside than where passes across are tried to end.
const QUANTILES: [f64; 2] = [1.0, 0.5];

/// A face on which passes run one way, and across near its rims.
struct Plan {
    task: Task,
    /// What is placed on the rims.
    start: State,
    /// How far it was after each lane.
    marks: Vec<Mark>,
    /// Everything.
    state: State,
}

struct Planner<'a, Inside> {
    /// Along the passes, and across.
    sites: [&'a Site<'a, Inside>; 2],
    work: u64,
    limits: [u64; 2],
}

/// The best way found to finish a face, by passes along, and across them on rims.
pub(super) fn best<Inside: Fn(Local) -> bool + Sync>(
    sites: [&Site<'_, Inside>; 2],
) -> Result<State, CoverError> {
    let site = sites[0];
    let options = site.options;
    // A count of locations is far below 2^53, and one without end saturates.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "see above")]
    let limits = [0.0, REST].map(|rest| ((options.effort + rest) * site.usual_work()) as u64);
    let mut planner = Planner { sites, work: 0, limits };
    let bounds = site.whole.bounds;
    let mut plan =
        planner.plan(bounds[1], if options.ahead < 2 { [0.0, 1.0] } else { [0.0, FIRST] })?;
    if options.method == Method::Widest && plan.state.report.given_up.is_none() && options.ahead > 1
    {
        plan = planner.rims(plan)?;
        let Plan { task, start, marks, state } = &plan;
        let (work, limit, portion) = (planner.work, limits[0], [RIMS, 1.0]);
        let mut search = Search { site, task, start, marks, work, limit, portion };
        let state = search.run(state.clone())?;
        planner.work = search.work;
        plan.state = state;
    }
    plan.state.report.work = planner.work;
    Ok(plan.state)
}

impl<Inside: Fn(Local) -> bool + Sync> Planner<'_, Inside> {
    /// Passes along between two places, and across outside them.
    fn plan(&mut self, inner: [f64; 2], portion: [f64; 2]) -> Result<Plan, CoverError> {
        let [site, cross] = self.sites;
        let [across, [low, high]] = site.whole.bounds;
        let method = site.options.method;
        let mut start = State::new();
        for rim in [[low, inner[0]], [inner[1], high]] {
            if rim[0] < rim[1] {
                let bounds = [rim, across];
                let task = Task { bounds, method, depth: 0, worth: f64::INFINITY };
                (start, _) = self.whole(cross, start, (&task, portion))?;
            }
        }
        let task = Task { bounds: [across, inner], method, depth: 0, worth: f64::INFINITY };
        let (state, marks) = self.whole(site, start.clone(), (&task, portion))?;
        Ok(Plan { task, start, marks, state })
    }

    fn whole(
        &mut self,
        site: &Site<'_, Inside>,
        state: State,
        (task, portion): (&Task, [f64; 2]),
    ) -> Result<(State, Vec<Mark>), CoverError> {
        let (work, limits) = (self.work, self.limits);
        let mut job = Job { site, state, work, limits, share: 0.0, portion };
        let marks = job.whole(task);
        self.work = job.work;
        Ok((job.state, marks?))
    }

    /// The plan, or a better one with passes across on rims where passes along are narrow.
    fn rims(&mut self, plan: Plan) -> Result<Plan, CoverError> {
        let mut best = plan;
        for end in [0, 1] {
            for place in self.places(&best, end) {
                if self.work > self.limits[0] {
                    return Ok(best);
                }
                let mut inner = best.task.bounds[1];
                inner[end] = place;
                match self.plan(inner, [FIRST, RIMS]) {
                    Ok(plan) if self.better(&plan, &best) => best = plan,
                    Err(CoverError::Cancelled(stop)) => return Err(stop.into()),
                    // What cannot be done that way is done as before.
                    _ => {}
                }
            }
        }
        Ok(best)
    }

    fn better(&self, one: &Plan, other: &Plan) -> bool {
        let rank = |plan: &Plan| {
            let missed = plan.state.missed.len();
            (missed, plan.state.price(self.sites[0].options))
        };
        one.state.report.given_up.is_none() && rank(one) < rank(other)
    }

    /// Where passes across might end at an end of the passes along (0 low, 1 high).
    fn places(&self, plan: &Plan, end: usize) -> Vec<f64> {
        let site = self.sites[0];
        let whole = site.whole.bounds[1];
        let at_end = |along: &[f64; 2]| (along[end] - whole[end]).abs() <= 0.0;
        let sides = || plan.state.sides.iter().filter(|side| at_end(&side.along));
        let cost: f64 = sides().map(|side| side.cost).sum();
        if cost < DEAR * (site.extent(0) + site.options.link) {
            return Vec::new();
        }
        let mut inner: Vec<f64> = sides().map(|side| side.along[1 - end]).collect();
        // From the rim inwards.
        inner.sort_by(|a, b| (a - whole[end]).abs().total_cmp(&(b - whole[end]).abs()));
        let place = |quantile: f64| {
            // A share of a small number.
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "see above"
            )]
            let index = (quantile * (inner.len() - 1) as f64) as usize;
            inner[index]
        };
        let mut places = QUANTILES.map(place).to_vec();
        places.dedup();
        places.retain(|place| (whole[0]..whole[1]).contains(place) && *place > whole[0]);
        places
    }
}
