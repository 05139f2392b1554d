//! A whole job on a machine whose rotary travel ends inside a pass: what the summary, the setup sheet
//! and the programs say of the retract, and that the part still comes out right.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use trunnion::files::{job, machine};
use trunnion::import::surface_json;
use trunnion::pipeline::{self, Job, Outcome};
use trunnion::surface::Face;
use trunnion::types::{Motion, Silent};

/// A gently curved 40 x 30 mm patch that looks up: tool axes go round the C axis.
const PATCH: &str = include_str!("../../../../fixtures/small-patch/patch.json");

const JOB: &str = include_str!("../../../../fixtures/small-patch/job.toml");

fn outcome(c_travel: &str) -> Outcome {
    let text = include_str!("../../../../machines/bc-trunnion.toml");
    let text = text.replacen("cyclic = 360.0", c_travel, 1);
    let machine = machine::parse(&text).unwrap().machine;
    let surface = surface_json::read(PATCH.as_bytes()).unwrap();
    let face = Face::new(1, surface, Vec::new()).unwrap();
    let job = Job::new(
        job::parse(&JOB.replacen("[0, 20, 0]", "[0, 0, 0]", 1)).unwrap(),
        &[face],
        &machine,
    )
    .unwrap();
    pipeline::run(&job, &Silent).unwrap()
}

#[test]
fn a_retract_in_a_pass_is_reported_everywhere_and_the_part_is_right() {
    let free = outcome("cyclic = 360.0");
    assert!(free.summary.motion.retracts.is_empty() && !free.setup.contains("retract"));

    let bound = outcome("limits = [-80.0, 110.0]");
    let summary = &bound.summary;
    assert!(summary.passed, "{:?}", summary.failures);
    for program in &summary.programs {
        let check = program.check.unwrap();
        assert!(check.excess <= 0.02 && check.gouge <= 0.002 && check.uncut == 0, "{check:?}");
    }
    let c = summary.motion.axes.iter().find(|axis| axis.name == "C").unwrap();
    assert!(c.range[0] >= -80.0 - 1e-6 && c.range[1] <= 110.0 + 1e-6, "{:?}", c.range);
    assert!(summary.motion.jerk_ratio.unwrap() <= 1.0);

    let [retract] = &summary.motion.retracts[..] else { panic!("{:?}", summary.motion.retracts) };
    assert!(
        retract.in_cut && retract.why.contains("C from ") && retract.why.contains("[-80, 110]")
    );
    assert!(retract.seconds > 1.0 && retract.seconds < summary.motion.duration);
    let longer = summary.motion.duration - free.summary.motion.duration;
    assert!(longer > 0.5 * retract.seconds, "{longer} {}", retract.seconds);

    let line = summary.warnings.iter().find(|line| line.contains("retract")).unwrap();
    assert!(
        line.contains("unwinds once") && line.contains("a turned setup may avoid it"),
        "{line}"
    );
    let [x, y, z] = retract.tip;
    let remark = format!("retract in a pass at X {x:.3} Y {y:.3} Z {z:.3} of the part, unwind C");
    assert!(bound.setup.contains(&remark), "{}", bound.setup);
    for program in &bound.programs {
        assert_eq!(program.text.matches(&remark).count(), 1, "{}", program.file);
    }

    // Out and back again the same way: lead-out first, lead-in last, to the place it left.
    let [retracted] = &bound.operations[0].followed.retracts[..] else { panic!() };
    let pieces = &bound.operations[0].followed.path.pieces[retracted.pieces.clone()];
    assert_eq!(pieces[0].motion, Motion::LeadOut);
    assert_eq!(pieces.last().unwrap().motion, Motion::LeadIn);
}
