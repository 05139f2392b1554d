//! The summary for scripts and for people.

use super::args::{FeedArgs, FeedMethod};
use super::path::{Rest, Table};
use super::plan::Planned;
use crate::form::OutputForm;
use crate::outcome::{Done, Failure};
use crate::text;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use trunnion::feed::{BindingLimit, FeedPlan, LimitBreach, LimitRatios};
use trunnion::types::Interval;

/// Ratios above 1 by no more than this are rounding. An acceleration between rows `h` apart is a
/// difference of terms as large as the distance to rest over `h`; rows keep half of their digits apart,
/// so those terms are below `1 / sqrt(eps)`, and their rounding is below `sqrt(eps)`.
pub(super) const ROUNDING: f64 = 1.490_116_119_384_765_6e-8;
/// Remedy for a broken limit.
const HINT: &str = " between rows; plan without --no-guarantee";
/// Most rests that are listed one by one.
pub(super) const MOST_LISTED: usize = 10;

/// Summary for scripts.
#[derive(Debug, serde::Serialize)]
pub(super) struct FeedSummary {
    method: &'static str,
    /// Rows looked ahead; all without.
    #[serde(skip_serializing_if = "Option::is_none")]
    window: Option<u32>,
    guarantee: bool,
    /// Time the schedule takes \[s\].
    duration: f64,
    /// Time the planning took \[s\], wall clock; not part of what is the same from run to run.
    seconds: f64,
    /// Rows of the schedule, and how many of them were inserted.
    points: usize,
    inserted: usize,
    /// Lower bound on the time of every schedule within the velocity and acceleration limits \[s\].
    lower_bound: f64,
    /// Largest ratios to the limits, found in a dense check between rows.
    ratios: Share,
    /// Upper bounds on these ratios everywhere.
    bounds: Share,
    /// Limits that bind, as shares of the time, largest first.
    binding: Vec<Bound>,
    /// Places inside the path at which the axes rest.
    rests: usize,
    pub(super) within_limits: bool,
    output: String,
}

#[derive(Debug, serde::Serialize)]
pub(super) struct Share {
    velocity: f64,
    acceleration: f64,
    jerk: Option<f64>,
}

impl From<LimitRatios> for Share {
    fn from(LimitRatios { velocity, acceleration, jerk, .. }: LimitRatios) -> Self {
        Self { velocity, acceleration, jerk }
    }
}

#[derive(Debug, serde::Serialize)]
struct Bound {
    limit: String,
    share: f64,
}

/// Prints the summary, and lists rests and broken limits on stderr.
pub(super) fn report<const N: usize>(
    args: &FeedArgs,
    form: OutputForm,
    planned: &Planned<'_, N>,
    table: &Table,
) -> Result<Done, Failure> {
    let rests = table.rests(planned.path);
    let listed = rests.len().min(MOST_LISTED);
    report_rests(&rests[..listed], rests.len() - listed);
    report_breaches(&planned.breaches, table);
    let summary = of(args, planned, table);
    print(args, form, &summary, describe)?;
    Ok(if summary.within_limits { Done::Kept } else { Done::Broken })
}

/// Returns the summary of a plan.
pub(super) fn of<const N: usize>(
    args: &FeedArgs,
    planned: &Planned<'_, N>,
    table: &Table,
) -> FeedSummary {
    let plan = &planned.plan;
    let kept = |ratio: f64| ratio <= 1.0 + ROUNDING;
    // Other methods do not promise jerk limits: breaking one is no failure.
    let jerk_kept = args.method != FeedMethod::Jerk || plan.bounds.jerk.is_none_or(kept);
    // Given speeds are judged by their breaches, plans by their guaranteed bounds.
    let within = if args.method == FeedMethod::Given {
        planned.breaches.is_empty()
    } else {
        kept(plan.bounds.velocity) && kept(plan.bounds.acceleration) && jerk_kept
    };
    FeedSummary {
        method: args.method.name(),
        window: args.window,
        guarantee: !args.no_guarantee
            && matches!(args.method, FeedMethod::Jerk | FeedMethod::Optimal),
        duration: plan.schedule.duration(),
        seconds: planned.seconds,
        points: plan.schedule.pieces.iter().map(|piece| piece.s.len()).sum(),
        inserted: plan.inserted,
        lower_bound: plan.lower_bound,
        ratios: plan.ratios.into(),
        bounds: plan.bounds.into(),
        binding: binding(plan, table),
        rests: table.rests(planned.path).len(),
        within_limits: within,
        output: args.ends.output().display().to_string(),
    }
}

/// Prints a summary: as JSON, or as text on the stream that the schedule does not use.
pub(super) fn print<S: serde::Serialize>(
    args: &FeedArgs,
    form: OutputForm,
    summary: &S,
    describe: impl Fn(&S) -> String,
) -> Result<(), Failure> {
    if form.is_json() {
        text::print_json(summary)?;
    } else if args.ends.to_stdout() {
        eprint!("{}", describe(summary));
    } else {
        text::print(&describe(summary))?;
    }
    Ok(())
}

/// Lists rests on stderr, and the count of those that are not listed.
pub(super) fn report_rests(rests: &[Rest], more: usize) {
    for Rest { s, line, jump } in rests {
        match jump {
            Some((name, by)) => {
                eprintln!("line {line}: the axes rest at s = {s}, where {name} jumps by {by}");
            }
            None => eprintln!("line {line}: the axes rest at s = {s}, where the row is repeated"),
        }
    }
    if more > 0 {
        eprintln!("and at {more} more rows; smooth the path to run through them");
    }
}

fn report_breaches(breaches: &[LimitBreach], table: &Table) {
    // Progress and remarks go to stderr: stdout may carry the schedule.
    for LimitBreach { s: Interval { low: from, high: to }, limit: name, ratio, worst, .. } in
        breaches.iter().take(MOST_LISTED)
    {
        let name = limit(*name, table);
        eprintln!("s = {from} to {to}: {name} is {ratio:.4} of its limit at s = {worst}");
    }
    if breaches.len() > MOST_LISTED {
        eprintln!(
            "and {} more segments; lower the column `speed` there",
            breaches.len() - MOST_LISTED
        );
    }
}

/// Returns the shares of the time by binding limit.
fn binding(plan: &FeedPlan, table: &Table) -> Vec<Bound> {
    let mut times: BTreeMap<String, f64> = BTreeMap::new();
    for (piece, binding) in plan.schedule.pieces.iter().zip(&plan.binding) {
        for (times_of, name) in piece.t.windows(2).zip(binding) {
            *times.entry(limit(*name, table)).or_default() += times_of[1] - times_of[0];
        }
    }
    // A schedule of no duration has no shares: nothing is divided by zero.
    let total = plan.schedule.duration().max(f64::MIN_POSITIVE);
    let bound = |(limit, time): (String, f64)| Bound { limit, share: time / total };
    let mut shares: Vec<Bound> = times.into_iter().map(bound).collect();
    shares.sort_by(|a, b| b.share.total_cmp(&a.share));
    shares
}

fn limit(name: BindingLimit, table: &Table) -> String {
    let of = |what: &str, axis: u8| format!("{what} of {}", table.layout.axis(usize::from(axis)));
    match name {
        BindingLimit::Velocity(axis) => of("velocity", axis),
        BindingLimit::Acceleration(axis) => of("acceleration", axis),
        BindingLimit::Chord(axis) => of("chord error", axis),
        BindingLimit::Jerk(axis) => of("jerk", axis),
        BindingLimit::Feed => "feed".into(),
        BindingLimit::Tip => "tip speed".into(),
        BindingLimit::Still => "nothing moves".into(),
        other => format!("{other:?}"),
    }
}

fn describe(summary: &FeedSummary) -> String {
    let mut out = String::new();
    let FeedSummary { duration, lower_bound, points, inserted, .. } = summary;
    // A path without length has a bound of 0.
    let above = 100.0 * (duration / lower_bound.max(f64::MIN_POSITIVE) - 1.0);
    // Writing to a string cannot fail.
    let _ =
        writeln!(out, "{duration:.6} s, {above:.2} % above the certified bound {lower_bound:.6} s");
    let _ =
        writeln!(out, "{points} rows, {inserted} of them inserted, in {:.4} s", summary.seconds);
    let row = |name: &str, share: &Share| {
        let jerk = share.jerk.map_or("    -   ".into(), |jerk| format!("{jerk:.6}"));
        format!("{name:<20}{:>10.6}{:>14.6}{jerk:>12}\n", share.velocity, share.acceleration)
    };
    let _ = writeln!(out, "of the limit          velocity  acceleration        jerk");
    out += &row("largest found", &summary.ratios);
    out += &row("guaranteed below", &summary.bounds);
    // The first five usually cover nearly all of the time.
    let binding = summary.binding.iter().take(5);
    let binding: Vec<String> =
        binding.map(|bound| format!("{} {:.1} %", bound.limit, 100.0 * bound.share)).collect();
    let _ = writeln!(out, "what binds: {}", binding.join(", "));
    if !summary.within_limits {
        let rows_alone = summary.method == FeedMethod::Optimal.name() && !summary.guarantee;
        let _ = writeln!(out, "a limit is broken{}", if rows_alone { HINT } else { "" });
    }
    if summary.output != "-" {
        let _ = writeln!(out, "wrote {}", summary.output);
    }
    out
}
