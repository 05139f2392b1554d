//! `trunnion setup`: searches the rotation of the workpiece.

use crate::form::OutputForm;
use crate::outcome::{Done, Failure};
use crate::progress::Bars;
use crate::run as jobs;
use std::path::PathBuf;
use trunnion::axes::{
    AxesError, EvaluatedSetup, PathTravel, SearchAssurance, SetupVerdict, TiltBounds,
};
use trunnion::files::setups::{
    LAYOUT, RotaryTravel, SetupAssurance, SetupBodies, SetupBounds, SetupEntry, SetupSummary,
};
use trunnion::machine::{FIRST_ROTARY, Machine};
use trunnion::pipeline::{self, BodiesInSetups, Job, SetupResult};
use trunnion::types::{Interval, Progress};

/// Most other setups that are listed.
const OTHERS: usize = 12;

#[derive(Debug, clap::Args)]
pub(crate) struct SetupArgs {
    /// Job file (TOML); paths in it are relative to it.
    job: PathBuf,
    /// Range of the tilt of the part's z from the machine's z, in degrees [default: 0..45, or 45 to either
    /// side of the job's tilt if that is larger].
    #[arg(long, value_name = "LO..HI", value_parser = interval, allow_hyphen_values = true)]
    tilt: Option<[f64; 2]>,
    /// Range of the direction of the tilt, in degrees about the machine's z from x (0) towards y (90)
    /// [default: -180..180].
    #[arg(long, value_name = "LO..HI", value_parser = interval, allow_hyphen_values = true)]
    towards: Option<[f64; 2]>,
    /// Range of the rotation about the part's own z before the tilt, in degrees [default: as in the job;
    /// any rotation if the workpiece-side rotary is not upright or has ends of travel].
    #[arg(long, value_name = "LO..HI", value_parser = interval, allow_hyphen_values = true)]
    turn: Option<[f64; 2]>,
}

/// Reads `LO..HI` in degrees, or one angle; returns radians.
fn interval(text: &str) -> Result<[f64; 2], String> {
    // One angle is an interval of its own.
    let (low, high) = text.split_once("..").unwrap_or((text, text));
    let angle = |text: &str| text.trim().parse::<f64>().ok().filter(|angle| angle.is_finite());
    match (angle(low), angle(high)) {
        (Some(low), Some(high)) if low <= high => Ok([low, high].map(f64::to_radians)),
        (Some(low), Some(high)) => {
            Err(format!("the smaller angle comes first: write {high}..{low}"))
        }
        _ => Err("write two angles in degrees, such as 0..30, or one, such as 20".to_owned()),
    }
}

pub(crate) fn run(args: &SetupArgs, form: OutputForm) -> Result<Done, Failure> {
    let bars = Bars::new();
    let SetupAnswer { summary, table } = answer(args, &bars)?;
    bars.finish();
    form.print(&summary, |_| table)?;
    let clear = summary.bodies.as_ref().is_none_or(|bodies| bodies.clear);
    Ok(if summary.found && clear { Done::Kept } else { Done::Broken })
}

/// Setups that were found, for callers in other languages.
#[derive(Debug)]
#[non_exhaustive]
pub struct SetupAnswer {
    /// Summary as `--json` prints it.
    pub summary: SetupSummary,
    /// The same for people.
    pub table: String,
}

/// Searches setups of a job.
pub(crate) fn answer(args: &SetupArgs, progress: &dyn Progress) -> Result<SetupAnswer, Failure> {
    let (job, warnings) = jobs::load(&args.job, None, progress)?;
    let bounds = bounds(args, &job)?;
    let found = pipeline::setup(&job, &bounds, progress).map_err(jobs::failure)?;
    let table = describe(&job, &bounds, &found, &warnings);
    Ok(SetupAnswer { summary: summary(&job, &bounds, &found, warnings), table })
}

fn bounds(args: &SetupArgs, job: &Job) -> Result<TiltBounds, Failure> {
    // Bounds that are not given follow the machine and the job's own setup.
    let usual = TiltBounds::usual(&job.kinematics);
    let bounds = TiltBounds {
        tilt: args.tilt.map_or(usual.tilt, Interval::from),
        towards: args.towards.map_or(usual.towards, Interval::from),
        turn: args.turn.map_or(usual.turn, Interval::from),
    };
    bounds.check().map(|()| bounds).map_err(|error| match error {
        // The error begins with the name of the bound, which is that of the option.
        AxesError::BadBounds { .. } => Failure::input(format!("--{error}")),
        error => Failure::input(error),
    })
}

/// Returns the answer of `--json`.
fn summary(
    job: &Job,
    bounds: &TiltBounds,
    found: &SetupResult,
    warnings: Vec<String>,
) -> SetupSummary {
    let machine = job.kinematics.machine();
    let search = &found.search;
    let degrees = |range: Interval| range.ends().map(|angle| rounded(angle.to_degrees()));
    let SearchAssurance { bound, except, evaluated, planned, .. } = search.assurance;
    SetupSummary {
        schema: LAYOUT.to_owned(),
        job: job.file.name.clone(),
        machine: machine.name.clone(),
        found: search.best.is_some(),
        bounds: SetupBounds {
            tilt: degrees(bounds.tilt),
            towards: degrees(bounds.towards),
            turn: degrees(bounds.turn),
        },
        before: entry(&search.before, machine, found.seconds[0]),
        after: search.best.as_ref().map(|(best, _)| entry(best, machine, found.seconds[1])),
        assurance: SetupAssurance {
            shown: shown(found),
            bound: bound.map(f64::to_degrees),
            except: except.to_degrees(),
            looked: evaluated,
            planned,
        },
        bodies: found.bodies.clone().map(
            |BodiesInSetups { passed_over, branch, clear, .. }| SetupBodies {
                passed_over,
                branch,
                clear,
            },
        ),
        clearance: job.file.setup.clearance,
        looked: search.evaluated,
        leaning: search.beyond_tilt,
        others: search.others.iter().map(|judged| entry(judged, machine, None)).collect(),
        warnings,
    }
}

fn entry(judged: &EvaluatedSetup, machine: &Machine, seconds: Option<f64>) -> SetupEntry {
    let fits = judged.verdict.fits();
    let names = machine.axes.iter().skip(FIRST_ROTARY).map(|axis| axis.name.clone());
    SetupEntry {
        origin: judged.setup.origin.into(),
        rotation: rotation(judged),
        tilt: rounded(judged.workpiece.tilt.to_degrees()),
        towards: rounded(judged.workpiece.towards.to_degrees()),
        turn: rounded(judged.workpiece.turn.to_degrees()),
        least_angle: judged.least.to_degrees(),
        fits: fits.is_some(),
        why_not: why_not(judged, machine),
        rotary_travel: fits.map(|travelled| {
            let travels = <[f64; 2]>::from(travelled.rotary).map(f64::to_degrees);
            names.zip(travels).map(|(axis, travel)| RotaryTravel { axis, travel }).collect()
        }),
        retracts: fits.map(|travelled| travelled.retracts),
        seconds,
    }
}

/// Returns true if the search is complete: no better setup is left, or none fits at all.
fn shown(found: &SetupResult) -> bool {
    let bound = found.search.assurance.bound;
    match (&found.search.best, bound) {
        (Some((best, _)), Some(bound)) => bound <= best.least + pipeline::SETUP_SHOWN,
        (_, bound) => bound.is_none(),
    }
}

/// Describes the assurance over all rotations within the bounds.
fn assured(found: &SetupResult) -> String {
    let SearchAssurance { bound, except, .. } = found.search.assurance;
    let apart = if except > 0.0 {
        format!(
            ", except for rotations within {:.2} deg of one that could not be planned",
            except.to_degrees().max(0.01)
        )
    } else {
        String::new()
    };
    match (&found.search.best, bound) {
        (Some((best, _)), Some(bound)) if shown(found) => {
            // Stated to a hundredth, as all angles here; less would promise too much.
            // No rotation has a larger least angle than the bound: the difference is what could still be gained.
            let more = (bound - best.least).to_degrees().max(0.01);
            let given = if bound - best.least > pipeline::SETUP_WITHIN {
                ", given up for less rotary travel"
            } else {
                ""
            };
            format!(
                "proven: no rotation that fits within the bounds is better by more than {more:.2} deg{given}{apart}"
            )
        }
        (Some(_), Some(bound)) => format!(
            "not proven to be the best: rotations with up to {:.2} deg were not all tried; narrow the bounds",
            bound.to_degrees()
        ),
        (None, Some(_)) => {
            "not proven that none fits: not all rotations were tried; narrow the bounds".to_owned()
        }
        (_, None) => format!("proven: no rotation within the bounds fits{apart}"),
    }
}

/// Returns the rotation in degrees, without the digits that the conversion from radians adds.
fn rotation(judged: &EvaluatedSetup) -> [f64; 3] {
    judged.angles.map(|angle| (angle.to_degrees() * 1e6).round() / 1e6 + 0.0)
}

fn why_not(judged: &EvaluatedSetup, machine: &Machine) -> Option<String> {
    let [.., second] = &machine.axes;
    match &judged.verdict {
        SetupVerdict::Fits(_) => None,
        SetupVerdict::BeyondTilt(by) => Some(format!(
            "the tool is inclined {:.2} deg beyond what the travel of {} allows",
            by.to_degrees(),
            second.name
        )),
        SetupVerdict::Short { by, axes } => {
            let axes = axes.join(" and ");
            Some(format!("travel of {axes} is {by:.1} mm short, wherever the origin is"))
        }
        SetupVerdict::Fails(error) => Some(error.to_string()),
        other => Some(format!("it does not fit: {other:?}")),
    }
}

/// Describes the result.
fn describe(job: &Job, bounds: &TiltBounds, found: &SetupResult, warnings: &[String]) -> String {
    let search = &found.search;
    let machine = job.kinematics.machine();
    let mut lines = vec![headline(job, found)];
    lines.extend(warnings.iter().map(|warning| format!("warning: {warning}")));
    if let Some((best, _)) = &search.best {
        lines.push(String::new());
        lines.extend(paste(job, best));
        lines.push(String::new());
        lines.extend(compare(machine, found, best));
    }
    lines.push(String::new());
    let [tilt, towards, turn] = [bounds.tilt, bounds.towards, bounds.turn].map(span);
    lines.push(format!(
        "examined {} rotations: tilt {tilt}, towards {towards}, turn {turn} deg; {} of them need {} \
         beyond its travel",
        search.evaluated,
        search.beyond_tilt,
        machine.axes.last().map_or("", |axis| axis.name.as_str())
    ));
    lines.push(assured(found));
    lines.extend(found.bodies.as_ref().map(bodies));
    if !search.others.is_empty() {
        lines.push(format!("planned as well, {}:", order(search.others.len())));
    }
    lines.extend(search.others.iter().take(OTHERS).map(|other| row(other, machine)));
    lines.join("\n") + "\n"
}

/// Describes whether bodies of the machine keep clear.
fn bodies(found: &BodiesInSetups) -> String {
    let count = found.passed_over;
    let setups = if count == 1 { "setup".to_owned() } else { format!("{count} setups") };
    let on = found.branch.as_ref().map(|branch| format!(" where {branch}")).unwrap_or_default();
    match (found.clear, count) {
        (true, 0) => format!("bodies of the machine, fixtures and stock keep clear{on}"),
        (true, _) => format!(
            "bodies of the machine, fixtures and stock keep clear{on}; better by their angle, but too near: the {setups} \
             named first below"
        ),
        (false, _) => format!(
            "BODIES COME TOO NEAR in the best {setups} that fit, on every branch that was tried: try a run, which changes \
             links and lean as well, or a longer tool, or a higher part"
        ),
    }
}

fn order(count: usize) -> String {
    if count > OTHERS { format!("the best {OTHERS} of {count}") } else { "best first".to_owned() }
}

fn headline(job: &Job, found: &SetupResult) -> String {
    let search = &found.search;
    let name = &job.file.name;
    let Some((best, _)) = &search.best else {
        let help = "allow more tilt or turn, take a shorter tool or clearance, or split the job";
        return format!(
            "{name}: NO SETUP FITS within the bounds; {help}. The nearest setups are listed below"
        );
    };
    let [before, after] = [search.before.least, best.least].map(f64::to_degrees);
    if best.setup == search.before.setup {
        return format!(
            "{name}: the setup of the job is the best within the bounds, {after:.2} deg from the singular directions"
        );
    }
    format!(
        "{name}: the path can keep {after:.2} deg from the singular directions ({before:.2} now)"
    )
}

/// Returns the lines for the job file.
fn paste(job: &Job, best: &EvaluatedSetup) -> [String; 4] {
    let list = |values: [f64; 3]| {
        let [x, y, z] = values.map(|value| format!("{value}"));
        format!("[{x}, {y}, {z}]")
    };
    // Two decimals are for the reader; the rotation itself is written in full.
    let [tilt, towards, turn] = [best.workpiece.tilt, best.workpiece.towards, best.workpiece.turn]
        .map(|angle| (angle.to_degrees() * 100.0).round() / 100.0 + 0.0);
    [
        "[setup]".to_owned(),
        format!("origin = {}", list(best.setup.origin.map(rounded).into())),
        format!(
            "rotation = {}  # tilted by {tilt} deg towards {towards} deg, turned by {turn} deg",
            list(rotation(best))
        ),
        format!("clearance = {}", job.file.setup.clearance),
    ]
}

/// Drops the digits that sums of tenths leave behind.
fn rounded(value: f64) -> f64 {
    (value * 1e6).round() / 1e6 + 0.0
}

fn compare(machine: &Machine, found: &SetupResult, best: &EvaluatedSetup) -> Vec<String> {
    let before = &found.search.before;
    let line = |name: &str, unit: &str, [now, then]: [Option<f64>; 2], decimals: usize| {
        let figure = |value: Option<f64>| {
            let text = |value: f64| format!("{value:.decimals$} {unit}").trim_end().to_owned();
            value.map_or_else(|| "-".to_owned(), text)
        };
        format!("  {name:<22}{:>14}{:>14}", figure(now), figure(then))
    };
    // A setup that does not fit has no travel, and gets a dash.
    let both = |figure: fn(&PathTravel) -> f64| {
        [before, best].map(|judged| judged.verdict.fits().map(figure))
    };
    let degrees = |judged: &EvaluatedSetup| Some(judged.least.to_degrees());
    let [.., first, second] = &machine.axes;
    let mut lines = vec![
        format!("  {:<22}{:>14}{:>14}", "", "now", "then"),
        line("least angle", "deg", [degrees(before), degrees(best)], 2),
        line(
            &format!("travel of {}", first.name),
            "deg",
            both(|of| of.rotary.first.to_degrees()),
            0,
        ),
        line(
            &format!("travel of {}", second.name),
            "deg",
            both(|of| of.rotary.second.to_degrees()),
            0,
        ),
        line("retracts to unwind", "", both(|of| of.retracts as f64), 0),
        line("planned time", "s", found.seconds, 1),
    ];
    // A rotation alone may leave travel: the search then moves the origin as well.
    if best.setup.origin != before.setup.origin {
        let [x, y, z]: [f64; 3] = (best.setup.origin - before.setup.origin).into();
        lines.push(format!(
            "  the origin is moved by [{x:.1}, {y:.1}, {z:.1}] mm to stay inside travel: make sure that the part can be clamped there"
        ));
    }
    if let Some(why) = why_not(before, machine) {
        lines.push(format!("  the setup of the job does not fit: {why}"));
    }
    lines
}

fn span(range: Interval) -> String {
    let [low, high] = range.ends().map(|angle| rounded(angle.to_degrees()));
    if low < high { format!("{low}..{high}") } else { format!("{low}") }
}

fn row(judged: &EvaluatedSetup, machine: &Machine) -> String {
    let [x, y, z] = rotation(judged);
    let least = judged.least.to_degrees();
    let what = why_not(judged, machine).unwrap_or_else(|| {
        let travels = judged.verdict.fits().map_or([0.0; 2], |of| of.rotary.into());
        let [first, second] = travels.map(f64::to_degrees);
        let [.., a, b] = &machine.axes;
        format!("fits; {} travels {first:.0} deg, {} {second:.0} deg", a.name, b.name)
    });
    format!("  [{x:.2}, {y:.2}, {z:.2}]: least angle {least:.2} deg, {what}")
}
