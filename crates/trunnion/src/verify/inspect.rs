//! One check of a program: faces, other faces, axes, stock and fixtures, in one report.

use super::check::check;
use super::clash::bodies::MachineBodies;
use super::clash::watch::{BodyReport, WatchedBodies, watch_bodies};
use super::deviation::side::behind;
use super::error::VerifyError;
use super::finding_kind::FindingKind;
use super::fixture::obstacle::Fixture;
use super::fixture::watch::{ClearanceOptions, ClearanceReport, FixtureApproach, clearance};
use super::input::CheckInput;
use super::options::{BoundOptions, CHORD_SHARE, CheckOptions};
use super::stock::carve::{StockOptions, StockReport, simulate};
use super::stock::collision::CollisionKind;
use super::stock::material::Stock;
use crate::surface::Face;
use crate::types::Progress;
use crate::verify::fast_block::FastBlock;
use crate::verify::report::{Finding, Report};
use crate::verify::state::{
    self, AffectedCuts, CoolantDemand, LengthUse, PlannedCuts, StateFinding, StateLimits,
    StateReport,
};
use std::collections::BTreeSet;

/// Ratio of times from which cuts are slower than any control's acceleration makes them.
const FAR_SLOWER: f64 = 30.0;

/// Ratio to the feed of the job from which a cut between slower ones is too fast.
const FAR_FASTER: f64 = 2.0;

/// Share of its limits up to which no axis explains slow cuts.
const HARDLY_LOADED: f64 = 0.1;

/// Grid on the faces that are not cut, over that on those that are.
const OTHERS_GRID: f64 = 3.0;

/// Meaning of the feeds of a program.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum FeedMeaning {
    /// Every block takes the time that its feed states: velocities and accelerations are judged.
    #[default]
    Timed,
    /// Feeds are upper limits, and the control plans its own speeds: only the path is judged.
    Cap,
}

/// A check of one program or CL file: what `trunnion check` and `trunnion run` both do.
///
/// The motion is measured against the faces it cuts and against all other faces of the part, the axes are audited, stock is
/// cut, and the distance from fixtures is found. Set what is known; what is not set is not checked.
///
/// # Example
///
/// A ball-end mill of radius 3 mm runs along the middle of a plate, 0.01 mm too deep:
///
/// ```
/// use trunnion::cutter::{Cutter, CutterSpec};
/// use trunnion::nalgebra::Point3;
/// use trunnion::nc::read::ClText;
/// use trunnion::surface::{Face, NurbsSurface, Surface};
/// use trunnion::types::Silent;
/// use trunnion::verify::{CheckInput, CheckOptions, DeviationTolerance, Finding, Inspection};
///
/// let cutter = Cutter::new(CutterSpec { length: 50.0, ..CutterSpec::ball(6.0) })?;
/// let corner = |x, y| Point3::new(x, y, 0.0);
/// let net = vec![vec![corner(0.0, -0.1), corner(0.0, 0.1)], vec![corner(9.0, -0.1), corner(9.0, 0.1)]];
/// let knots = || vec![0.0, 0.0, 1.0, 1.0];
/// let plate = NurbsSurface::new([1, 1], [knots(), knots()], net, None).expect("a plane");
/// let faces = [Face::new(1, Surface::Nurbs(plate), vec![])?];
/// let text = "FEDRAT/600,MMPM\nGOTO/-1,0,-0.01,0,0,1\nGOTO/10,0,-0.01,0,0,1\nFINI\n";
/// let locations = ClText::new(text.to_owned(), 20)?;
///
/// let tolerance = DeviationTolerance { excess: 0.02, gouge: 0.002 };
/// let input = CheckInput::locations(&locations, &cutter).faces(&faces);
/// let found = Inspection::new(input, CheckOptions::of_tolerance(tolerance, 0.2)).run(&Silent)?;
/// let is_gouge = |finding: &&Finding| matches!(finding, Finding::Gouge(_));
/// assert_eq!(found.report.findings.iter().filter(is_gouge).count(), 1);
/// let lowest = found.report.deviation.lowest.ok_or("nothing was measured")?;
/// assert!((lowest.height + 0.01).abs() < 1e-3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Inspection<'a> {
    input: CheckInput<'a>,
    options: CheckOptions,
    others: &'a [Face],
    feeds: FeedMeaning,
    coolant: CoolantDemand,
    planned: Option<PlannedCuts<'a>>,
    stock: Option<(&'a Stock, StockOptions)>,
    fixtures: Option<(&'a [Fixture], &'a ClearanceOptions)>,
    bodies: Option<(&'a MachineBodies, &'a ClearanceOptions)>,
}

/// Everything that a check found.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct InspectionReport {
    /// The faces that are cut, with the findings of all faces, and the audit of the axes.
    pub report: Report,
    /// The other faces of the part.
    pub others: OtherFaces,
    /// The stock after the last move.
    pub stock: Option<CutStock>,
    /// Distance from fixtures.
    pub clearance: Option<ClearanceReport>,
    /// Distances of the machine's bodies.
    pub bodies: Option<BodyReport>,
    /// State of the control during cuts; `None` for cutter locations. Its findings are among those of `report`.
    pub state: Option<StateReport>,
}

/// Result on the faces that are not cut.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct OtherFaces {
    /// Measured points.
    pub points: usize,
    /// Deepest gouge \[mm\]; 0 without one.
    pub deepest: f64,
    /// Guaranteed bound on the depth of gouges \[mm\], where one was proven.
    pub gouge_bound: Option<f64>,
}

/// Stock that was cut.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct CutStock {
    /// Volumes and collisions, those with fixtures among them.
    pub report: StockReport,
    /// The remaining material.
    pub remaining: Stock,
}

impl<'a> Inspection<'a> {
    /// Starts a check of motion against the faces of `input`.
    pub fn new(input: CheckInput<'a>, options: CheckOptions) -> Self {
        Self {
            input,
            options,
            others: &[],
            feeds: FeedMeaning::Timed,
            coolant: CoolantDemand::Unknown,
            planned: None,
            stock: None,
            fixtures: None,
            bodies: None,
        }
    }

    /// Sets the other faces of the part, which must not be gouged.
    #[must_use]
    pub fn others(self, others: &'a [Face]) -> Self {
        Self { others, ..self }
    }

    /// Sets the meaning of the feeds; [`FeedMeaning::Timed`] unless set.
    #[must_use]
    pub fn feeds(self, feeds: FeedMeaning) -> Self {
        Self { feeds, ..self }
    }

    /// Sets the need of coolant; [`CoolantDemand::Unknown`] unless set.
    #[must_use]
    pub fn coolant(self, coolant: CoolantDemand) -> Self {
        Self { coolant, ..self }
    }

    /// Sets the tools and the feed that a job plans: cuts without its tools, and cuts far slower, are findings.
    #[must_use]
    pub fn planned(self, planned: PlannedCuts<'a>) -> Self {
        Self { planned: Some(planned), ..self }
    }

    /// Sets the stock that is cut; of each kind of collision the `worst` lines are kept.
    #[must_use]
    pub fn stock(self, stock: &'a Stock, worst: usize) -> Self {
        let tolerance = stock.tolerance(self.options.total);
        Self { stock: Some((stock, StockOptions { tolerance, worst })), ..self }
    }

    /// Sets the fixtures that the tool must not touch.
    #[must_use]
    pub fn fixtures(self, fixtures: &'a [Fixture], options: &'a ClearanceOptions) -> Self {
        Self { fixtures: Some((fixtures, options)), ..self }
    }

    /// Sets the bodies of the machine, which must not touch each other, the tool, stock and fixtures. Stock that is set
    /// too counts as it is cut so far. Of a CL file nothing is known of the machine.
    #[must_use]
    pub fn bodies(self, bodies: &'a MachineBodies, options: &'a ClearanceOptions) -> Self {
        Self { bodies: Some((bodies, options)), ..self }
    }

    /// Runs the motion and reports everything that is found.
    ///
    /// # Errors
    ///
    /// [`VerifyError`]; [`VerifyError::FromBehind`] for faces that the tool cuts from their backs.
    pub fn run(&self, progress: &dyn Progress) -> Result<InspectionReport, VerifyError> {
        // No height on faces that are cut from behind would mean anything.
        let found = if self.input.faces.is_empty() { None } else { behind(&self.input)? };
        if let Some(found) = found {
            let (from_back, examined) = (found.from_back, found.examined);
            return Err(VerifyError::FromBehind { from_back, examined });
        }
        let mut report = check(&self.input, &self.options, progress)?;
        if self.feeds == FeedMeaning::Cap {
            keep_path(&mut report);
        }
        let others = self.inspect_others(&mut report, progress)?;
        let mut stock = self.cut_stock(progress)?;
        let clearance = match self.fixtures {
            Some((fixtures, options)) => Some(clearance(&self.input, fixtures, options, progress)?),
            None => None,
        };
        if let (Some(stock), Some(clearance)) = (&mut stock, &clearance) {
            add_contacts(&mut stock.report, clearance);
        }
        let bodies = self.watch_bodies(progress)?;
        let mut state = self.audit_state();
        if let Some(state) = &mut state {
            state.findings.extend(self.slow_cuts(&report, state.cuts));
            state.findings.extend(self.fast_cuts(&report));
        }
        let findings = state.iter().flat_map(|state| &state.findings);
        report.findings.extend(findings.map(|finding| Finding::State(*finding)));
        Ok(InspectionReport { report, others, stock, clearance, bodies, state })
    }

    /// Audits spindle, tool length and smoothing of a program.
    fn audit_state(&self) -> Option<StateReport> {
        let program = self.input.source()?;
        let limits = StateLimits {
            tolerance: (!self.input.faces.is_empty()).then_some(self.options.total),
            length: if self.input.has_tool_length() {
                LengthUse::Compensated
            } else {
                LengthUse::Irrelevant
            },
            coolant: self.coolant,
            planned: self.planned,
        };
        Some(state::audit(program.steps(), &limits))
    }

    /// Judges the time of all cuts by the planned feed.
    fn slow_cuts(&self, report: &Report, cuts: Option<AffectedCuts>) -> Option<StateFinding> {
        let (planned, audit, cuts) = (self.planned?, report.audit.as_ref()?, cuts?);
        let ratio = (audit.duration - audit.rapid) * planned.feed / audit.motion.cut_length;
        // Where an axis cannot follow, the tip is slow for a good reason.
        let loads = audit.axes.iter().flat_map(|axis| [&axis.velocity, &axis.acceleration]);
        if loads.map(|load| load.worst).fold(0.0, f64::max) > HARDLY_LOADED {
            return None;
        }
        (ratio > FAR_SLOWER).then_some(StateFinding::SlowCuts { cuts, ratio })
    }

    /// Finds blocks that cut far faster than planned, between slower ones.
    fn fast_cuts(&self, report: &Report) -> Option<StateFinding> {
        let (feed, audit) = (self.planned?.feed, report.audit.as_ref()?);
        let is_fast = |block: &&FastBlock| block.speed > FAR_FASTER * feed;
        let fast: Vec<&FastBlock> = audit.fast.iter().filter(is_fast).collect();
        if fast.is_empty() {
            return None;
        }
        // What a block finishes it cuts; on the way through the air nothing is fast.
        let samples = report.maps.iter().flat_map(|map| map.samples.iter().flatten());
        let finished =
            samples.filter(|sample| sample.height.is_some_and(|s| s <= self.options.total));
        let lines: BTreeSet<u32> = finished.filter_map(|sample| sample.line).collect();
        let cuts = || fast.iter().copied().filter(|block| lines.contains(&block.line));
        let fastest = *cuts().max_by(|a, b| a.speed.total_cmp(&b.speed))?;
        Some(StateFinding::FastCuts { fastest, count: cuts().count(), feed })
    }

    /// Measures the faces that are not cut, on a coarser grid, and adds their gouges to the findings.
    fn inspect_others(
        &self,
        report: &mut Report,
        progress: &dyn Progress,
    ) -> Result<OtherFaces, VerifyError> {
        if self.others.is_empty() {
            return Ok(OtherFaces::default());
        }
        // These faces may keep any height: only gouges are bounded and reported.
        let bounds = self.options.bounds.map(|bounds| BoundOptions { excess: false, ..bounds });
        let options =
            CheckOptions { grid: OTHERS_GRID * self.options.grid, bounds, ..self.options };
        let input = self.input.faces(self.others).rest(&[]);
        let other = check(&input, &options, progress)?;
        // Uncut points and excess are no defects on faces that are not to be cut.
        let is_gouge = |finding: &Finding| finding.kind() == FindingKind::Gouge;
        report.findings.extend(other.findings.into_iter().filter(is_gouge));
        let deepest = other.deviation.lowest.map_or(0.0, |lowest| (-lowest.height).max(0.0));
        let gouge_bound = other.deviation.bounds.map(|bounds| bounds.gouge);
        Ok(OtherFaces { points: other.deviation.points, deepest, gouge_bound })
    }

    /// Finds the distances of the machine's bodies; `None` for cutter locations.
    fn watch_bodies(&self, progress: &dyn Progress) -> Result<Option<BodyReport>, VerifyError> {
        let (Some((bodies, watch)), Some(kinematics)) = (self.bodies, self.input.real()) else {
            return Ok(None);
        };
        let controls = self.input.controls()?;
        let run = self.input.run(controls.as_ref(), CHORD_SHARE * watch.tolerance)?;
        let cutters = self.input.cutters();
        let (watch, stock) = (*watch, self.stock);
        let watched = WatchedBodies { bodies, cutters: &cutters, kinematics, watch, stock };
        watch_bodies(&watched, &run, progress).map(Some)
    }

    fn cut_stock(&self, progress: &dyn Progress) -> Result<Option<CutStock>, VerifyError> {
        let Some((stock, options)) = &self.stock else { return Ok(None) };
        let mut remaining = (*stock).clone();
        let report = simulate(&self.input, &mut remaining, options, progress)?;
        Ok(Some(CutStock { report, remaining }))
    }
}

/// Keeps of a report what does not depend on the speeds that a control plans by itself.
fn keep_path(report: &mut Report) {
    report.audit = None;
    // Where the program states vectors the control chooses the rotaries, too.
    let vectors = report.choices.vectors > 0;
    report.findings.retain(|finding| match finding {
        Finding::Velocity { .. } | Finding::Acceleration { .. } => false,
        Finding::Travel { .. } => !vectors,
        _ => true,
    });
}

/// Adds the contacts with fixtures to the collisions with stock.
fn add_contacts(stock: &mut StockReport, clearance: &ClearanceReport) {
    stock.collisions.extend(clearance.near.iter().filter_map(FixtureApproach::collision));
    stock.lines.extend(clearance.hits.map(|hits| (CollisionKind::Fixture, hits)));
    stock.collisions.sort_by_key(|hit| (hit.line, hit.kind));
}
