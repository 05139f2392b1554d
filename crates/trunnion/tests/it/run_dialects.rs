//! Every dialect of a run is measured against the part, or has the same blocks as one that is.

use trunnion::files::{job, machine};
use trunnion::import::surface_json;
use trunnion::pipeline::{self, CheckedProgram, Job};
use trunnion::surface::Face;
use trunnion::types::Silent;

const PATCH: &str = include_str!("../../../../fixtures/small-patch/patch.json");
const JOB: &str = include_str!("../../../../fixtures/small-patch/job.toml");
const MACHINE: &str = include_str!("../../../../machines/bc-trunnion.toml");

#[test]
fn every_program_is_measured_once() {
    let dialects = r#"dialects = ["fanuc", "siemens", "haas", "g93", "linuxcnc", "heidenhain", "siemens-axes"]"#;
    let text = JOB.replacen(r#"dialects = ["linuxcnc", "g93"]"#, dialects, 1);
    let text = text.replacen("grid = 0.5", "grid = 1.0", 1);
    let machine = machine::parse(MACHINE).unwrap().machine;
    let surface = surface_json::read(PATCH.as_bytes()).unwrap();
    let face = Face::new(1, surface, Vec::new()).unwrap();
    let job = Job::new(job::parse(&text).unwrap(), &[face], &machine).unwrap();
    let outcome = pipeline::run(&job, &Silent).unwrap();
    assert!(outcome.summary.passed, "{:?}", outcome.summary.failures);
    // Tip and angles by F, vectors, axes by time, tip and angles by time; the others have the blocks of one of these,
    // but what is timed is audited, too.
    let wanted = [
        ("fanuc", None),
        ("siemens", None),
        ("haas", Some("fanuc")),
        ("g93", None),
        ("linuxcnc", None),
        ("heidenhain", Some("siemens")),
        ("siemens-axes", Some("fanuc")),
    ];
    let mut worst = Vec::new();
    for (program, (dialect, same_as)) in outcome.programs.iter().zip(wanted) {
        assert_eq!((program.dialect, program.same_as), (dialect, same_as));
        assert_eq!(program.check.is_some(), same_as.is_none(), "{dialect}");
        assert!(program.unread.is_none(), "{dialect}: {:?}", program.unread);
        let Some(check) = &program.check else { continue };
        assert!(check.deviation.points > 1000 && check.deviation.uncut == 0, "{dialect}");
        assert_eq!(check.audit.is_some(), ["g93", "linuxcnc"].contains(&dialect));
        worst.push(check.deviation.highest.unwrap().height);
    }
    // The blocks differ by no more than their share of the tolerance.
    let [low, high] =
        worst.iter().fold([f64::INFINITY, 0.0_f64], |[low, high], &of| [low.min(of), high.max(of)]);
    assert!(high <= 0.02 && high - low <= 0.005, "{worst:?}");
}

/// Numbers of a line behind letters.
fn words(line: &str, letters: &str) -> Vec<f64> {
    let of = |letter: char| {
        line.split_whitespace()
            .find_map(|word| word.strip_prefix(letter)?.trim_start_matches('=').parse().ok())
    };
    letters.chars().filter_map(of).collect()
}

/// Axes that run rapid moves each at its own speed come down beside the way: so the tool first goes above the place where
/// it comes down.
#[test]
fn every_program_comes_down_where_it_stands() {
    let dialects =
        r#"dialects = ["fanuc", "siemens", "haas", "linuxcnc", "heidenhain-axes", "siemens-axes"]"#;
    let text = JOB.replacen(r#"dialects = ["linuxcnc", "g93"]"#, dialects, 1);
    let machine = machine::parse(MACHINE).unwrap().machine;
    let surface = surface_json::read(PATCH.as_bytes()).unwrap();
    let face = Face::new(1, surface, Vec::new()).unwrap();
    let job = Job::new(job::parse(&text).unwrap(), &[face], &machine).unwrap();
    let outcome = pipeline::run(&job, &Silent).unwrap();
    assert_eq!(outcome.programs.len(), 6);
    for CheckedProgram { dialect, text, .. } in &outcome.programs {
        let lines: Vec<&str> = text.lines().collect();
        let machine_coordinates = |line: &str| {
            ["G53", "SUPA", "M91"].iter().any(|code| line.contains(code))
                && words(line, "XY").len() == 2
        };
        let above = lines.iter().position(|line| machine_coordinates(line)).unwrap();
        let rotary = lines[..above].iter().rev().find_map(|line| {
            let found = words(line, "BC");
            (found.len() == 2).then_some(found)
        });
        let down = lines[above + 1..].iter().find(|line| words(line, "XYZ").len() == 3).unwrap();
        // With these axes, at any height, the place of the first move is right below the tool.
        let (xy, bc) = (words(lines[above], "XY"), rotary.unwrap());
        let kinematics = &job.kinematics;
        let mut q = kinematics.machine().home();
        (q[0], q[1]) = (xy[0], xy[1]);
        for (axis, named) in machine.axes.iter().enumerate().skip(3) {
            q[axis] = bc[usize::from(named.name == "C")].to_radians();
        }
        let tool = kinematics.forward(&q);
        let tip = kinematics.setup().rotation * tool.tip.coords;
        let axis = kinematics.setup().rotation * tool.axis.into_inner();
        let to = nalgebra::Vector3::from_vec(words(down, "XYZ")) - tip;
        assert!(to.dot(&axis) < -1.0, "{dialect}: {to:?}");
        assert!(to.cross(&axis).norm() < 0.01, "{dialect}: {} from {}", down, lines[above]);
    }
}
