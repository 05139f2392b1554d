//! CL files as CAM systems write them: one motion in every dialect, hostile text, real files.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]
#![expect(clippy::print_stdout, reason = "says which files are absent")]

use nalgebra::{Point3, UnitVector3, Vector3};
use proptest::prelude::*;
use std::fmt::Write as _;
use std::path::Path;
use trunnion_nc::read::{
    self, ClFile, ClItem, ClMotion, ClPath, ClReader, ClRecord, ClTally, cl_records,
};

/// Who writes.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Writer {
    Nx,
    Creo,
    SolidWorks,
    Catia,
    Autodesk,
}

const WRITERS: [Writer; 5] =
    [Writer::Nx, Writer::Creo, Writer::SolidWorks, Writer::Catia, Writer::Autodesk];

/// One location of a motion that is to be written.
#[derive(Debug, Clone)]
struct Step {
    tip: [f64; 3],
    /// A new tool axis.
    axis: Option<[f64; 3]>,
    rapid: bool,
    /// A new feed \[mm/min\].
    feed: Option<f64>,
    /// On an arc about z with this centre's distance behind the start, and this turn.
    arc: Option<(f64, f64)>,
}

fn steps() -> impl Strategy<Value = Vec<Step>> {
    let tip = prop::array::uniform3(-300.0..300.0f64);
    let axis = prop::option::of(prop::array::uniform3(-0.6..0.6f64));
    let feed = prop::option::of(50.0..5000.0f64);
    let arc = prop::option::weighted(0.3, (1.0..40.0f64, 0.05..6.2f64));
    let step = (tip, axis, prop::bool::weighted(0.2), feed, arc);
    let step = step.prop_map(|(tip, axis, rapid, feed, arc)| {
        let axis = axis.map(|[i, j, k]| unit([i, j, 1.0 + k]));
        Step { tip, axis, rapid, feed, arc: arc.filter(|_| !rapid) }
    });
    prop::collection::vec(step, 2..30)
}

fn unit(v: [f64; 3]) -> [f64; 3] {
    UnitVector3::new_normalize(Vector3::from(v)).into_inner().into()
}

/// What is meant: the locations, and the arcs that lead to them.
#[derive(Debug, Clone)]
struct Meant {
    tip: Point3<f64>,
    axis: Vector3<f64>,
    /// mm/min; `None` for rapid.
    feed: Option<f64>,
    /// Centre and turn about z, clockwise below zero.
    arc: Option<(Point3<f64>, f64)>,
}

fn meant(steps: &[Step]) -> Vec<Meant> {
    let mut axis = [0.0, 0.0, 1.0];
    let mut feed = 1000.0;
    let mut all: Vec<Meant> = Vec::new();
    for (index, step) in steps.iter().enumerate() {
        axis = step.axis.unwrap_or(axis);
        feed = step.feed.unwrap_or(feed);
        let rapid = step.rapid || index == 0;
        let mut one = Meant {
            tip: Point3::from(step.tip),
            axis: Vector3::from(axis),
            feed: (!rapid).then_some(feed),
            arc: None,
        };
        if let (Some((radius, turn)), Some(before)) = (step.arc, all.last()) {
            let center = before.tip - Vector3::new(radius, 0.0, 0.0);
            let turn = if index % 2 == 0 { turn } else { -turn };
            one.tip = center + Vector3::new(radius * turn.cos(), radius * turn.sin(), 0.0);
            one.arc = Some((center, turn));
            one.axis = before.axis;
            axis = one.axis.into();
        }
        all.push(one);
    }
    all
}

/// A number as `SolidWorks` CAM writes it: `.5`, `16.`, `0`.
fn short(x: f64) -> String {
    let text = format!("{x:.6}");
    let text = text.trim_end_matches('0');
    match text {
        "-0." | "0." => "0".to_owned(),
        text => text.strip_prefix("0.").map_or(text.to_owned(), |rest| format!(".{rest}")),
    }
}

impl Writer {
    fn head(self) -> &'static str {
        match self {
            Self::Nx => {
                "TOOL PATH/FINISH,TOOL,B10\nTLDATA/MILL,10.0000,5.0000,75.0000,0.0000,0.0000\n\
                 MSYS/5.0,6.0,7.0,0.0,1.0,0.0,-1.0,0.0,0.0\n$$ centerline data\nPAINT/PATH\n\
                 PAINT/SPEED,10\n"
            }
            Self::Creo => {
                "$$*          Pro/CLfile  Version 8.0 - 8.0.3.0\nPARTNO / WING\n$$-> FEATNO / 32\n\
                 MACHIN / UNCX01, 1\nUNITS / MM\nLOADTL / 7\n$$-> CUTTER / 10.000000\n\
                 $$-> CSYS / 1.0, 0.0, 0.0, 0.0,  $\n   0.0, 1.0, 0.0, 0.0, $\n 0.0, 0.0, 1.0, 0.0\n\
                 SPINDL / RPM, 9000.0,  CLW\n"
            }
            Self::SolidWorks => {
                "PARTNO/1\nUNIT/MM\nINSERT/[HOLDER=A] costs $ 5\nCUTTER/10.,5.,0,0,0,0,93.\n\
                 LOAD/TOOL,7\nCSI_SET_FLUTE_LENGTH/32.\nTRNTYP/WORLD,0,0,0\n\
                 CSYS/1.,0,0,0,0,1.,0,0,0,0,1.,0\n"
            }
            Self::Catia => {
                "$$ -----\nPARTNO WING\nCUTTER/ 10.000000,  5.000000,$\n  5.0, 0.0, 0.0, 0.0, 50.0\n\
                 MULTAX/ON\nTOOLNO/7,MILL\nLOADTL/7,1\nSPINDL/ 8000.0000,RPM,CLW\nPPRINT $$ why\n"
            }
            Self::Autodesk => {
                "MODE/MILL\nPARTNO/'WING'\nPPRINT/'(a, b)'\nUNITS/MM\nMULTAX/ON\n\
                 CUTTER/10., 5., 5., 5., 0., 0., 40.\nLOADTL/7, 0, 60., 7\nSPINDL/8000., RPM, CLW\n"
            }
        }
    }

    fn write(self, motion: &[Meant]) -> String {
        let mut text = self.head().to_owned();
        let mut feed = None;
        let mut before: Option<&Meant> = None;
        for one in motion {
            match one.feed {
                None => text += if self == Self::SolidWorks { "RAPID/\n" } else { "RAPID\n" },
                Some(value) if feed != Some(value) => {
                    feed = Some(value);
                    match self {
                        Self::Nx => writeln!(text, "PAINT/COLOR,42\nFEDRAT/MMPM,{value:.6}"),
                        Self::Creo => writeln!(text, "FEDRAT / {value:.6},  MMPM"),
                        Self::SolidWorks => writeln!(text, "FEDRAT/{},MMPM", short(value)),
                        Self::Catia => writeln!(text, "FEDRAT/ {value:.4},MMPM"),
                        Self::Autodesk => writeln!(text, "fedrat/{value:.6}, mmpm"),
                    }
                    .unwrap();
                }
                Some(_) => {}
            }
            if !self.arc(&mut text, one, before) {
                self.goto(&mut text, one, before);
            }
            before = Some(one);
        }
        text + match self {
            Self::Nx => "PAINT/SPEED,10\nEND-OF-PATH\n",
            Self::Creo => "$$-> END / \nFINI \n",
            _ => "FINI\n",
        }
    }

    fn goto(self, text: &mut String, one: &Meant, before: Option<&Meant>) {
        let [p, a] = [one.tip.coords, one.axis];
        let same = before.is_some_and(|before| before.axis == one.axis);
        match self {
            Self::Nx if same => writeln!(text, "GOTO/{:.6},{:.6},{:.6}", p.x, p.y, p.z),
            Self::Nx => writeln!(
                text,
                "GOTO/{:.6},{:.6},{:.6},{:.9},{:.9},{:.9}",
                p.x, p.y, p.z, a.x, a.y, a.z
            ),
            Self::Creo => writeln!(
                text,
                "GOTO / {:.10}, {:.10}, {:.10}, $\n {:.10}, {:.10}, {:.10}",
                p.x, p.y, p.z, a.x, a.y, a.z
            ),
            Self::SolidWorks => {
                let n = [p.x, p.y, p.z, a.x, a.y, a.z].map(short);
                writeln!(text, "GOTO/{}", n.join(","))
            }
            Self::Catia => writeln!(
                text,
                "GOTO  / {:11.5}, {:11.5}, {:11.5}, {:9.6}, {:9.6}, {:9.6}",
                p.x, p.y, p.z, a.x, a.y, a.z
            ),
            Self::Autodesk => writeln!(
                text,
                "GOTO/{:.6}, {:.6}, {:.6}, {:.9}, {:.9}, {:.9}",
                p.x, p.y, p.z, a.x, a.y, a.z
            ),
        }
        .unwrap();
    }

    /// Writes an arc, the location at its end included; false if there is none.
    fn arc(self, text: &mut String, one: &Meant, before: Option<&Meant>) -> bool {
        let (Some((c, turn)), Some(before)) = (one.arc, before) else { return false };
        let [k, r] = [turn.signum(), (before.tip - c).norm()];
        match self {
            Self::Nx => writeln!(
                text,
                "CIRCLE/{:.6},{:.6},{:.6},0.0,0.0,{k:.7},{r:.6},0.06,0.5,10.0,5.0",
                c.x, c.y, c.z
            ),
            Self::Creo => {
                writeln!(text, "CIRCLE / {:.10}, {:.10}, {:.10}, $\n0.0, 0.0, {k:.1}, {r:.10}", c.x, c.y, c.z)
                    .unwrap();
                // A point on the way, of the same circle.
                let half = 0.5 * turn;
                let tip = c + Vector3::new(r * half.cos(), r * half.sin(), 0.0);
                self.goto(text, &Meant { tip, ..one.clone() }, Some(before));
                Ok(())
            }
            Self::SolidWorks => {
                let n = [c.x, c.y, c.z, 0.0, 0.0, k].map(short);
                writeln!(text, "CIRCLE/{}", n.join(","))
            }
            Self::Catia => {
                let e = one.tip;
                writeln!(
                    text,
                    "INDIRV/ 0.00000, {k:8.5}, 0.00000\nTLON,GOFWD/ (CIRCLE/ {:.6}, {:.6}, {:.6},$\n \
                     {r:.6}),ON,2,INTOF,$\n(LINE/ {:.6}, {:.6}, {:.6}, {:.6}, {:.6}, {:.6})",
                    c.x, c.y, c.z, c.x, c.y, c.z, e.x, e.y, e.z
                )
                .unwrap();
                return true;
            }
            // The older of its writers does not turn the axis round.
            Self::Autodesk => writeln!(
                text,
                "MOVARC/{:.6}, {:.6}, {:.6}, 0., 0., 1., {r:.6}, ANGLE, {:.6}",
                c.x, c.y, c.z, turn.abs().to_degrees()
            ),
        }
        .unwrap();
        self.goto(text, one, Some(before));
        true
    }
}

/// Records of one arc as one.
fn joined(file: &ClFile) -> Vec<(ClRecord, f64)> {
    let mut all: Vec<(ClRecord, f64)> = Vec::new();
    for record in &file.records {
        let signed = match record.way {
            ClPath::Arc(arc) => arc.sweep * arc.normal.z.signum(),
            _ => 0.0,
        };
        match (all.last_mut(), record.way) {
            (Some((last, turn)), ClPath::Arc(arc))
                if *turn != 0.0 && same_circle(last, &arc.center) =>
            {
                *turn += signed;
                last.pose = record.pose;
            }
            _ => all.push((*record, signed)),
        }
    }
    all
}

fn same_circle(last: &ClRecord, center: &Point3<f64>) -> bool {
    matches!(last.way, ClPath::Arc(arc) if (arc.center - center).norm() < 1e-9)
}

proptest! {
    /// One motion, written as each system would, is read as that motion.
    #[test]
    fn every_dialect_says_the_same(steps in steps()) {
        let motion = meant(&steps);
        for writer in WRITERS {
            let text = writer.write(&motion);
            let file = read::cl(&text, 20)
                .map_err(|faults| TestCaseError::fail(format!("{writer:?}: {faults:?}\n{text}")))?;
            let records = joined(&file);
            prop_assert_eq!(records.len(), motion.len(), "{:?}\n{}", writer, text);
            let corner = if writer == Writer::Creo { 0.0 } else { 5.0 };
            prop_assert_eq!(file.cutter, Some([10.0, corner]));
            prop_assert_eq!(file.tool, (writer != Writer::Nx).then_some(7));
            for ((record, turn), one) in records.iter().zip(&motion) {
                prop_assert!((record.pose.tip - one.tip).norm() < 2e-5, "{:?} {:?}", writer, record);
                prop_assert!((record.pose.axis.into_inner() - one.axis).norm() < 2e-6);
                match (record.motion, one.feed) {
                    (ClMotion::Rapid, None) => {}
                    (ClMotion::Feed(feed), Some(given)) => {
                        prop_assert!((feed * 60.0 - given).abs() < 1e-4);
                    }
                    _ => prop_assert!(false, "{:?} {:?} {:?}", writer, record, one),
                }
                let given = one.arc.map_or(0.0, |(_, turn)| turn);
                prop_assert!((turn - given).abs() < 1e-4, "{:?} {} {}\n{}", writer, turn, given, text);
            }
        }
    }

    /// Lines one by one, with `$` at any comma, say the same as the text at once.
    #[test]
    fn joined_lines_say_the_same(steps in steps(), cuts in prop::collection::vec(any::<bool>(), 64)) {
        let text = Writer::Autodesk.write(&meant(&steps));
        let mut cuts = cuts.iter().cycle();
        let mut cut = String::new();
        for line in text.lines() {
            let joins = line.starts_with("GOTO") || line.starts_with("MOVARC");
            for part in line.split_inclusive(',') {
                cut += part;
                if joins && part.ends_with(',') && *cuts.next().unwrap() {
                    cut += "$ 00010\r\n";
                }
            }
            cut += "\r\n";
        }
        let whole = read::cl(&text, 5).unwrap();
        let parts: Vec<_> = cl_records(cut.lines(), 5).map(Result::unwrap).collect();
        prop_assert_eq!(parts.len(), whole.records.len());
        for (part, whole) in parts.iter().zip(&whole.records) {
            prop_assert_eq!((part.pose, part.motion, part.way), (whole.pose, whole.motion, whole.way));
        }
    }

    /// No bytes stop the reader, and what it lets through is finite.
    #[test]
    fn hostile_bytes_end_in_a_result(
        steps in steps(),
        which in 0..5usize,
        cuts in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>(), 0..3u8), 0..20),
    ) {
        let mut bytes = WRITERS[which].write(&meant(&steps)).into_bytes();
        for (at, byte, how) in cuts {
            let at = at.index(bytes.len());
            match how {
                0 => bytes[at] = byte,
                1 => { bytes.remove(at); }
                _ => { let piece = bytes[..at].to_vec(); bytes.extend(piece); bytes.truncate(1 << 16); }
            }
        }
        let text = String::from_utf8_lossy(&bytes);
        let mut reader = ClReader::new(30);
        for line in text.lines() {
            if let Some(ClItem::Location(record)) = reader.line(line) {
                let finite = |record: &ClRecord| record.pose.tip.iter().all(|x| x.is_finite());
                prop_assert!(record.straight(None, 0.1).iter().all(finite));
            }
        }
        for fault in reader.faults() {
            prop_assert!(fault.line as usize <= text.lines().count() && !fault.message.is_empty());
        }
    }
}

#[test]
fn bytes_without_any_sense_end_in_a_result() {
    let mut seed = 0x9e37_79b9_u32;
    for round in 0..200 {
        let bytes: Vec<u8> = (0..400)
            .map(|_| {
                seed ^= seed << 13;
                seed ^= seed >> 17;
                seed ^= seed << 5;
                let letters = b"GOTO/CIRCLETLON,$()\n\n.0123456789- \xff\0";
                if round % 2 == 0 {
                    letters[seed as usize % letters.len()]
                } else {
                    seed.to_le_bytes()[1]
                }
            })
            .collect();
        let _ = read::cl(&String::from_utf8_lossy(&bytes), 10);
    }
}

#[test]
fn faults_name_line_column_word_and_remedy() {
    let text = "PARTNO A\nGOTO/1,2,3\nFEDRAT/-5,MMPM\nGOTO/1, 2,x3\nNURBS/2\nTRANS/1,0,0\n\
                GOTO/1,2,3,0,$\n  0,abc\nGOTO/1,2\n12,3\nFEDRAT/100\nGOTO/0,0,0,0,0,2\nFINI\n";
    let faults = read::cl(text, 20).unwrap_err();
    let places: Vec<_> = faults.iter().map(|fault| (fault.line, fault.column)).collect();
    assert_eq!(places, [(3, 8), (4, 11), (5, 1), (6, 1), (8, 5), (9, 6), (10, 1), (12, 6)]);
    for (fault, part) in
        faults.iter().zip(["-5", "x3", "NURBS", "TRANS", "abc", "2 numbers", "12,3"])
    {
        assert!(fault.message.contains(part) && !fault.help.is_empty(), "{fault}");
    }
    assert_eq!(read::cl(text, 3).unwrap_err().len(), 3);
    let unit = read::cl("RAPID\nGOTO/1,2,3\nFEDRAT/IPM,12\nGOTO/1,2,4\nFINI\n", 3).unwrap_err();
    assert!(unit[0].message.contains("no UNITS") && unit[0].line == 3, "{unit:?}");
    let cut = read::cl("RAPID\nGOTO/1,2,3\n", 3).unwrap_err();
    assert!(cut[0].message.contains("no FINI"));
    let behind = read::cl("RAPID\nGOTO/1,2,3\nFINI\nGOTO/4,5,6\n", 3).unwrap_err();
    assert_eq!(behind[0].line, 4);
}

#[test]
fn what_is_kept_is_warned_of_once() {
    let text = "QUUX/1\nQUUX/2\nCUTCOM/LEFT\nGOHOME\nRAPID\nGOTO/1,2,3,0,0,0.9997\nFINI\n";
    let file = read::cl(text, 20).unwrap();
    let lines: Vec<_> = file.warnings.iter().map(|warning| warning.line).collect();
    assert_eq!(lines, [1, 3, 4, 6]);
}

/// The part is turned and moved between two operations; it is the same part.
#[test]
fn operations_in_two_frames_meet_in_the_first() {
    let text = "MSYS/0,0,0,1,0,0,0,1,0\nRAPID\nGOTO/10,0,5\nEND-OF-PATH\n\
                MSYS/10,0,5,0,1,0,-1,0,0\nRAPID\nGOTO/0,0,0\nRAPID\nGOTO/1,0,0,1,0,0\nEND-OF-PATH\n";
    let file = read::cl(text, 5).unwrap();
    assert!((file.records[1].pose.tip - file.records[0].pose.tip).norm() < 1e-12);
    assert!((file.records[2].pose.tip - Point3::new(10.0, 1.0, 5.0)).norm() < 1e-12);
    assert!((file.records[2].pose.axis.into_inner() - Vector3::y()).norm() < 1e-12);
}

#[test]
fn axes_hold_until_the_frame_changes() {
    let text = "MULTAX/ON\nRAPID\nGOTO/0,0,0,0,0.6,0.8\nRAPID\nGOTO/1,0,0\nMULTAX/OFF\nRAPID\nGOTO/2,0,0\n\
                TRNTYP/WORLD,0,0,0\nCSYS/0,0,-1.,0,-1.,0,0,0,0,1.,0,0\nRAPID\nGOTO/3,0,0\nFINI\n";
    let axes: Vec<_> = read::cl(text, 5)
        .unwrap()
        .records
        .iter()
        .map(|record| record.pose.axis.into_inner())
        .collect();
    let tilted = Vector3::new(0.0, 0.6, 0.8);
    assert!((axes[0] - tilted).norm() < 1e-15 && axes[1] == axes[0]);
    assert_eq!(axes[2], Vector3::z());
    assert!((axes[3] + Vector3::x()).norm() < 1e-15);
}

#[test]
fn inches_turns_and_deltas() {
    let text = "UNITS/INCHES\nSPINDL/RPM,1200,CLW\nFROM/0,0,1\nFEDRAT/0.01,IPR\nGODLTA/1,0,0\nGODLTA/-.5\n\
                FEDRAT/IPM,12.\nGOTO/2,0,0\nFINI\n";
    let file = read::cl(text, 5).unwrap();
    let tips: Vec<_> = file.records.iter().map(|record| record.pose.tip).collect();
    assert!((tips[0] - Point3::new(25.4, 0.0, 25.4)).norm() < 1e-12);
    assert!((tips[1] - Point3::new(25.4, 0.0, 12.7)).norm() < 1e-12);
    let feeds: Vec<f64> = file
        .records
        .iter()
        .map(|record| match record.motion {
            ClMotion::Feed(feed) => feed,
            ClMotion::Rapid => 0.0,
        })
        .collect();
    assert!((feeds[0] - 0.01 * 25.4 * 20.0).abs() < 1e-12 && (feeds[2] - 5.08).abs() < 1e-12);
}

/// Cycles of five writers: the same hole.
#[test]
fn cycles_are_holes() {
    for cycle in [
        "CYCLE/DEEP2,FEDTO,5.,1STPECK,2.,SUBPECK,1.,MMPM,300,RAPTO,3.,RTRCTO,10.",
        "CYCLE/DRILL,DEEP,RAPTO,3.,FEDTO,-5.,RTRCTO,10.,MMPM,300.,STEP1,2.,STEP2,1.",
        "CYCLE / DEEP, DEPTH, 5.0, STEP, 2.0, SUBPECK, 1.0, MMPM, 300.0, RTRCTO, 10., CLEAR,$\n 3.0",
        "CYCLE/DEEP, 5., INCR, 2., STEP2, 1., MMPM, 300., 3., RTRCTO, 10.",
        "CYCLE/DEEPHL,   5.000000,  300.000000,MMPM,   3.000000,INCR,2.,STEP2,1.,RTRCTO,10.",
    ] {
        let text = format!(
            "RAPID\nGOTO/0,0,50\n{cycle}\nGOTO/7,0,0\nGOTO/9,0,0\nCYCLE/OFF\nRAPID\nGOTO/0,0,50\nFINI\n"
        );
        let file = read::cl(&text, 5).unwrap();
        let ClPath::Hole(hole) = file.records[1].way else {
            panic!("{cycle}: {:?}", file.records[1])
        };
        let heights = Vector3::new(hole.clear, hole.depth, hole.retract);
        assert_eq!(heights, Vector3::new(3.0, 5.0, 10.0), "{cycle}");
        assert_eq!(hole.steps, Some([2.0, 1.0]), "{cycle}");
        assert_eq!(file.records[1].motion, ClMotion::Feed(5.0));
        assert!(matches!(file.records[2].way, ClPath::Hole(_)));
        assert_eq!(file.records[3].way, ClPath::Straight);
    }
    let fault = read::cl("CYCLE/DRILL,RAPTO,3\nFINI\n", 5).unwrap_err();
    assert!(fault[0].message.contains("no depth"));
}

/// A file of ../shared/samples; `None`, and a line that says so, where it is absent.
fn sample(name: &str) -> Option<String> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/samples").join(name);
    let text = std::fs::read(&path).ok();
    if text.is_none() {
        println!("{} is absent: not read", path.display());
    }
    text.map(|bytes| String::from_utf8_lossy(&bytes).into_owned())
}

fn tally(text: &str) -> ClTally {
    let mut tally = ClTally::new(0.001);
    for record in cl_records(text.lines(), 10) {
        tally.push(&record.unwrap());
    }
    tally
}

/// Counts, lengths, times and ranges of real files, as another program has them that shares nothing with the reader.
#[test]
fn real_files_are_read_without_a_false_fault() {
    struct Pinned {
        name: &'static str,
        counts: [usize; 3],
        /// Rapid and feed \[mm\], time \[s\], turns of the tool axis \[deg\].
        sums: [f64; 4],
        tip: [[f64; 2]; 3],
        axis: [[f64; 2]; 3],
        /// Words warned of.
        warned: &'static [&'static str],
    }
    let files = [
        Pinned {
            name: "solidworkscam_tilt-support1.apt",
            counts: [184, 0, 4],
            sums: [2_145.906_976, 2_462.716_469, 176.043_462, 0.0],
            tip: [[-38.6372, 38.8682], [-8.8, 48.8], [-16.1029, 252.786]],
            axis: [[-0.173_648; 2], [0.0; 2], [0.984_808; 2]],
            warned: &["INSERT"],
        },
        Pinned {
            name: "solidworkscam_wall-holes.apt",
            counts: [1864, 336, 6],
            sums: [10_073.834_820, 30_797.262_409, 1_550.410_009, 90.0],
            tip: [[-25.0, 60.0], [-10.0, 110.0], [-65.3819, 25.0]],
            axis: [[-1.0, 0.0], [0.0; 2], [0.0, 1.0]],
            warned: &["INSERT", "CUTCOM"],
        },
        Pinned {
            name: "creo_bohren_1.ncl",
            counts: [4, 0, 2],
            sums: [49.551_310, 15.0, 18.0, 0.0],
            tip: [[-16.7804, -7.2291], [-23.0; 2], [-3.0, 2.0]],
            axis: [[0.0; 2], [0.0; 2], [1.0; 2]],
            warned: &[],
        },
    ];
    for pinned in files {
        let Some(text) = sample(pinned.name) else { continue };
        let tally = tally(&text);
        println!("{}: {tally:?}", pinned.name);
        assert_eq!([tally.locations, tally.arcs, tally.holes], pinned.counts, "{}", pinned.name);
        let sums = [tally.rapid_length, tally.cut_length, tally.seconds, tally.turn.to_degrees()];
        for (sum, given) in sums.iter().zip(pinned.sums) {
            assert!((sum - given).abs() < 1e-5, "{}: {sums:?}", pinned.name);
        }
        for part in 0..3 {
            for end in 0..2 {
                // Arcs were looked at in chords within 0.001 mm.
                assert!((tally.tip[end][part] - pinned.tip[part][end]).abs() < 1.1e-3);
                assert!((tally.axis[end][part] - pinned.axis[part][end]).abs() < 1e-6);
            }
        }
        let warnings = read::cl(&text, 5).unwrap().warnings;
        assert_eq!(warnings.len(), pinned.warned.len(), "{warnings:?}");
        for (warning, word) in warnings.iter().zip(pinned.warned) {
            assert!(warning.message.starts_with(word), "{warning}");
        }
    }
}

/// Tips and feeds \[mm/min\] of the straight moves of a file; rapids have none.
fn straight(text: &str) -> Vec<([f64; 3], Option<f64>)> {
    let file = read::cl(&format!("{text}\nFINI\n"), 10).unwrap();
    let mut before = None;
    let mut all = Vec::new();
    for record in &file.records {
        for one in record.straight(before.as_ref(), 0.01) {
            let feed = match one.motion {
                ClMotion::Rapid => None,
                ClMotion::Feed(feed) => Some((feed * 60.0 * 1e6).round() / 1e6),
            };
            all.push((one.pose.tip.coords.into(), feed));
        }
        before = Some(record.end());
    }
    all
}

#[test]
fn cycles_take_their_feed_from_the_spindle() {
    let start = "SPINDL/RPM,500,CLW\nFEDRAT/100,MMPM\nRAPID\nGOTO/0,0,20";
    // 500 turns of 1.5 mm a minute, in and out.
    let expected =
        [([0.0, 0.0, 20.0], None), ([5.0, 0.0, 2.0], None), ([5.0, 0.0, -8.0], Some(750.0))];
    for feed in ["MMPR,1.5", "PITCH, 1.5", "IPR,0.059055118", "TPI,16.93333333333"] {
        let moves = straight(&format!("{start}\nCYCLE/TAP,FEDTO,8,{feed},RAPTO,2\nGOTO/5,0,0"));
        for (found, expected) in moves.iter().zip(expected) {
            let off = (Vector3::from(found.0) - Vector3::from(expected.0)).norm();
            assert!(off < 1e-12, "{feed}: {moves:?}");
            let [one, other] = [found.1, expected.1].map(|feed| feed.unwrap_or(0.0));
            assert!((one - other).abs() < 1e-3, "{feed}: {moves:?}");
        }
        assert!(moves[3].1.is_some(), "a tap comes out with its feed");
    }
    let without = "FEDRAT/100\nGOTO/0,0,20\nCYCLE/TAP,FEDTO,8,MMPR,1.5,RAPTO,2\nFINI\n";
    assert!(read::cl(without, 5).unwrap_err()[0].message.contains("no SPINDL"));
    // Up to where the tool stood before.
    let moves = straight(&format!(
        "{start}\nCYCLE/DRILL,FEDTO,8,RAPTO,2,RTRCTO,AUTO\nGOTO/5,0,0\nGOTO/9,0,0"
    ));
    let heights: Vec<f64> = moves.iter().map(|one| one.0[2]).collect();
    assert_eq!(heights, [20.0, 20.0, 2.0, -8.0, 20.0, 20.0, 2.0, -8.0, 20.0]);
}

#[test]
fn no_statement_is_lost_behind_another() {
    let moves = straight("FEDRAT/60\nRAPID,GOTO/1,2,3\nRAPID , GODLTA / 0,0,5\nGOTO/1,2,4");
    let expected =
        [([1.0, 2.0, 3.0], None), ([1.0, 2.0, 8.0], None), ([1.0, 2.0, 4.0], Some(60.0))];
    assert_eq!(moves, expected);
    let cases = [
        ("RAPID,GO/PAST,L1", 7, "behind RAPID"),
        ("RAPID; GOTO/1,2,3", 6, "second statement"),
        ("FEDRAT/60,MMPM ; GOTO/1,2,3", 16, "second statement"),
        ("LOADTL/DRILL", 8, "names no tool"),
        ("FROM/1,2", 6, "FROM has 3"),
        ("REPLAY/2", 1, "moves the tool"),
        ("CALL/HOLES", 1, "moves the tool"),
        ("TLLFT,GORGT/L1", 1, "moves the tool"),
        ("CYCLE/BORE,NODRAG,FEDTO,5", 12, "steps aside"),
        ("CYCLE/TURN,FEDTO,5", 7, "not known"),
        ("MSYS/0,0,5,1,0,0,0,1,0", 6, "in none"),
    ];
    for (line, column, part) in cases {
        let text = format!("FEDRAT/60\nGOTO/0,0,0\n{line}\nGOTO/1,1,1\nFINI\n");
        let fault = read::cl(&text, 5).unwrap_err()[0].clone();
        assert!(fault.message.contains(part) && !fault.help.is_empty(), "{line}: {fault}");
        assert_eq!((fault.line, fault.column), (3, column), "{line}: {fault}");
    }
    let file = read::cl("LOADTL/5.\nFEDRAT/60\nGOTO/0,0,0\nFINI\n", 5).unwrap();
    assert_eq!(file.tool, Some(5));
}
