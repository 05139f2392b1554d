//! From the layout to checked data: units, and rules that a schema cannot express.

use super::super::document::Document;
use super::super::schema;
use super::cutting::cutting;
use super::data::{
    JobFile, JobLinkBlocks, JobOperation, JobPart, JobPrograms, JobSetup, JobTolerance, JobTool,
    MotionMethod, MotionSettings, ToleranceSplit,
};
use super::layout::LAYOUT;
use super::operation::{self, OperationDefaults, ReadOperations};
use super::part::part;
use super::raw::{
    RawCutting, RawDialect, RawLinkBlocks, RawMachineRef, RawMethod, RawMotion, RawMotionMethod,
    RawOutput, RawPart, RawPrograms, RawSetup, RawStock, RawStrategy, RawTolerance, RawTool,
    RawVerify,
};
use super::solid::{fixtures, stock};
use super::strategy::{side_of, strategy};
use super::tool::{others, tool};
use crate::nc::write::OutputFormat;
use crate::types::{Diagnostic, Diagnostics};
use nalgebra::Vector3;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Reads a job file.
///
/// # Errors
///
/// Every fault that was found, in order of lines: syntax, unknown and missing keys, wrong types,
/// values out of range, and values that do not go together.
pub fn parse(text: &str) -> Result<JobFile, Diagnostics> {
    let mut doc = Document::open(text, LAYOUT, &layout_of(text))?;
    let job = sections(&mut doc);
    let places = doc.finish()?;
    match job {
        Some(job) => Ok(JobFile { places, ..job }),
        None => Err(Diagnostic::whole("the job file cannot be read").into()),
    }
}

/// Tables that a job needs, unless every operation has its own.
const OWN_TABLES: [&str; 2] = ["cutting", "tool"];

/// Returns the layout, which requires the tables that some operation of the job leaves out.
fn layout_of(text: &str) -> serde_json::Value {
    let mut layout = schema::job_value();
    let (root, _) = DeTable::parse_recoverable(text);
    let root = root.into_inner();
    let operations = match root.get(operation::KEY).map(Spanned::get_ref) {
        Some(DeValue::Array(operations)) => operations.iter().map(Spanned::get_ref).collect(),
        _ => Vec::new(),
    };
    let states = |operation: &&DeValue<'_>, key: &str| matches!(operation, DeValue::Table(table) if table.contains_key(key));
    for key in OWN_TABLES {
        let all = !operations.is_empty() && operations.iter().all(|one| states(one, key));
        if let Some(required) = layout.get_mut("required").and_then(|list| list.as_array_mut())
            && !all
        {
            required.push(key.into());
        }
    }
    layout
}

fn sections(doc: &mut Document<'_>) -> Option<JobFile> {
    // Every section is read before any is missed, so that all faults come together.
    let name = doc.section::<String>("name");
    let part = doc.section::<RawPart>("part").and_then(|raw| part(raw, doc));
    let setup = doc.section::<RawSetup>("setup").map(|raw| setup(&raw));
    let stock = doc.section::<RawStock>("stock").map(|raw| stock(&raw, doc));
    let fixtures = fixtures(doc);
    let own_tool = doc.section::<RawTool>("tool").and_then(|raw| tool(raw, "tool", doc));
    let tolerance = doc.section::<RawTolerance>("tolerance").and_then(|raw| tolerance(&raw, doc));
    let machine = doc.section::<RawMachineRef>("machine").map(|raw| raw.file);
    let motion = doc.or_default::<RawMotion>("motion").and_then(|raw| motion(&raw, doc));
    let output = doc.or_default::<RawOutput>("output");
    let mut verify = doc.or_default::<RawVerify>("verify");
    let other_tools = verify.as_mut().and_then(|verify| verify.tool.take()).unwrap_or_default();
    let read = ReadOperations::read(doc);
    let described = own_tool.iter().chain(read.described()).map(|tool| tool.number).collect();
    // The tools are taken out: they are checked with the same rules as [tool], under their own paths.
    let other_tools = others(other_tools, described, doc);
    let first = if read.is_empty() {
        alone(own_tool, part.as_ref(), doc)
    } else {
        let defaults = OperationDefaults {
            tool: own_tool.as_ref(),
            others: other_tools.as_deref().unwrap_or_default(),
            faces: part.as_ref().map(|part| &part.faces),
        };
        read.with(defaults, doc)
    };
    // Absent stock is fine; stock that could not be read is not.
    let stock = match stock {
        Some(stock) => Some(stock?),
        None => None,
    };
    let verify = verify?;
    let output = output?;
    let mut operations = first?;
    let other_tools = beside(&operations, other_tools?);
    let JobOperation { faces, tool, strategy, cutting, .. } = operations.first()?.clone();
    if operations.len() == 1 {
        operations.clear();
    }
    Some(JobFile {
        name: name?,
        part: JobPart { faces, ..part? },
        setup: setup?,
        stock,
        fixtures: fixtures?,
        tool,
        other_tools,
        tolerance: tolerance?,
        strategy,
        cutting,
        operations,
        machine: machine?,
        motion: motion?,
        dialects: dialects(&output),
        programs: programs(&output),
        link_blocks: link_blocks(&output),
        verify_grid: verify.grid,
        stock_cell: verify.stock_cell,
        fixture_clearance: verify.fixture_clearance,
        places: super::super::places::KeyPositions::default(),
    })
}

/// Returns the only operation of a job without `[[operation]]` tables.
fn alone(
    tool: Option<JobTool>,
    part: Option<&JobPart>,
    doc: &mut Document<'_>,
) -> Option<Vec<JobOperation>> {
    let raw = doc.or_default::<RawStrategy>("strategy");
    if raw.as_ref().is_some_and(|raw| raw.method == RawMethod::Rest) {
        let message = "method \"rest\" cuts what the operations before have left, and this job is one operation";
        doc.fault("strategy.method", message, "write it in an [[operation]] behind another one");
    }
    let strategy = raw.and_then(|raw| strategy(&raw, tool.as_ref(), "strategy", doc));
    let cutting = doc.section::<RawCutting>("cutting").map(|raw| cutting(&raw));
    // A rule between two sections needs both; a faulty one has its own diagnostics.
    if let (Some(tool), Some(strategy)) = (&tool, &strategy) {
        side_of(tool, strategy, "strategy", doc);
    }
    let faces = part?.faces.clone();
    let name = String::new();
    Some(vec![JobOperation { name, faces, tool: tool?, strategy: strategy?, cutting: cutting? }])
}

/// Returns the tools besides that of the first operation, each once.
fn beside(operations: &[JobOperation], others: Vec<JobTool>) -> Vec<JobTool> {
    let mut known: Vec<u32> =
        operations.first().map(|first| first.tool.number).into_iter().collect();
    let mut tools = others;
    known.extend(tools.iter().map(|tool| tool.number));
    for JobOperation { tool, .. } in operations {
        if !known.contains(&tool.number) {
            known.push(tool.number);
            tools.push(tool.clone());
        }
    }
    tools
}

fn setup(raw: &RawSetup) -> JobSetup {
    let origin = Vector3::from(raw.origin);
    JobSetup { origin, angles: raw.rotation.map(f64::to_radians), clearance: raw.clearance }
}

fn tolerance(raw: &RawTolerance, doc: &mut Document<'_>) -> Option<JobTolerance> {
    let RawTolerance { total, gouge, ref split } = *raw;
    if gouge > total {
        let message = format!("gouge {gouge} mm is above total {total} mm");
        doc.fault("tolerance.gouge", message, "lower gouge or raise total");
    }
    let split = ToleranceSplit {
        strip: split.strip,
        path: split.path,
        linearisation: split.linearisation,
        rounding: split.rounding,
        control: split.control,
        singular: split.singular,
        smoothing: split.smoothing,
    };
    let parts = [
        split.strip,
        split.path,
        split.linearisation,
        split.rounding,
        split.control,
        split.singular,
        split.smoothing,
    ];
    // The pipeline divides what is left: the fixed shares alone must fit.
    let sum: f64 = parts.iter().flatten().sum();
    if sum > total {
        let message = format!("the shares add up to {sum} mm, more than total {total} mm");
        doc.fault("tolerance.split", message, "lower a share or raise total");
    }
    (gouge <= total && sum <= total).then_some(JobTolerance { total, gouge, split })
}

/// Reads the planner and the sampling.
fn motion(raw: &RawMotion, doc: &mut Document<'_>) -> Option<MotionSettings> {
    let method = match raw.method {
        RawMotionMethod::Optimal => MotionMethod::Optimal,
        RawMotionMethod::Jerk => MotionMethod::Jerk,
        RawMotionMethod::Blocks => MotionMethod::Blocks,
        RawMotionMethod::Given => {
            // The schema lists it because `trunnion feed` has it.
            let message = "a job cannot prescribe speeds yet";
            let help = "write `method = \"jerk\"`, `\"optimal\"` or `\"blocks\"`";
            doc.fault("motion.method", message, help);
            return None;
        }
    };
    Some(MotionSettings {
        method,
        servo_period: raw.servo_period,
        chord: [raw.chord, raw.chord_angle.map(f64::to_radians)],
    })
}

fn programs(raw: &RawOutput) -> JobPrograms {
    match raw.programs {
        RawPrograms::One => JobPrograms::One,
        RawPrograms::Each => JobPrograms::Each,
    }
}

fn link_blocks(raw: &RawOutput) -> JobLinkBlocks {
    match raw.link_blocks {
        RawLinkBlocks::Long => JobLinkBlocks::Long,
        RawLinkBlocks::Short => JobLinkBlocks::Short,
    }
}

fn dialects(raw: &RawOutput) -> Vec<OutputFormat> {
    let mut dialects = Vec::new();
    for dialect in &raw.dialects {
        let dialect = match dialect {
            RawDialect::LinuxCnc => OutputFormat::LinuxCnc,
            RawDialect::G93 => OutputFormat::G93,
            RawDialect::Fanuc => OutputFormat::Fanuc,
            RawDialect::FanucVector => OutputFormat::FanucVector,
            RawDialect::Haas => OutputFormat::Haas,
            RawDialect::Siemens => OutputFormat::Siemens,
            RawDialect::SiemensAxes => OutputFormat::SiemensAxes,
            RawDialect::Heidenhain => OutputFormat::Heidenhain,
            RawDialect::HeidenhainAxes => OutputFormat::HeidenhainAxes,
        };
        // A dialect listed twice would write the same file twice.
        if !dialects.contains(&dialect) {
            dialects.push(dialect);
        }
    }
    dialects
}

#[cfg(test)]
mod tests {
    use super::super::data::{JobFeedDirection, JobPlacement};
    use super::*;

    const EXAMPLE: &str = include_str!("../../../../../examples/bezier-patch/job.toml");

    fn faults(text: &str) -> Vec<String> {
        let faults = parse(text).err().unwrap_or_else(|| panic!("no fault in\n{text}"));
        faults.iter().map(ToString::to_string).collect()
    }

    /// The example with one line replaced.
    fn with(line: &str, by: &str) -> String {
        assert!(EXAMPLE.contains(line), "{line}");
        EXAMPLE.replacen(line, by, 1)
    }

    #[test]
    fn the_example_is_in_internal_units() {
        let job = parse(EXAMPLE).unwrap();
        assert_eq!(job.name, "bezier patch");
        assert_eq!((job.tool.major, job.tool.minor, job.tool.length), (10.0, 6.0, 120.0));
        assert!((job.cutting.feed - 50.0).abs() < 1e-12);
        assert!((job.cutting.spindle_rpm() - 8000.0).abs() < 1e-9);
        assert!((job.setup.angles[1].to_degrees() - 20.0).abs() < 1e-12);
        assert_eq!(job.setup.rotation() * Vector3::y(), Vector3::y());
        assert_eq!(job.dialects, [OutputFormat::LinuxCnc, OutputFormat::G93]);
        assert_eq!(job.motion.chord, [None; 2]);
        let chords = with("servo_period", "chord = 0.001\nchord_angle = 0.18\nservo_period");
        let chords = parse(&chords).unwrap().motion.chord.map(Option::unwrap);
        assert!((chords[0] - 0.001).abs() < 1e-15 && (chords[1].to_degrees() - 0.18).abs() < 1e-12);
        assert_eq!(job.places.get("tool.minor_radius").line, 20);
        assert_eq!(job.places.get("tool.holder"), job.places.get("tool"));
    }

    #[test]
    fn several_faults_come_together_in_order_of_lines() {
        let text = with("minor_radius = 6 ", "minor_radus = 6 ")
            .replace("feed = 3000", "feed = -3")
            .replace("gouge = 0.002", "gouge = 0.2")
            .replace("[strategy]", "[stratgey]")
            .replace("number = 1", "number = \"1\"")
            .replace("origin = [-381, -254, -505]", "origin = [0, nan]");
        let expected = [
            "12:10: `setup.origin` needs 3 entries, but has 2",
            "12:14: `setup.origin.1` = nan is not a finite number",
            "17:10: `tool.number` must be a whole number, not a text\n  help: write it without quotes: 1",
            "20:1: unknown key `minor_radus` in [tool]\n  help: did you mean `minor_radius`?",
            "26:9: gouge 0.2 mm is above total 0.02 mm\n  help: lower gouge or raise total",
            "28:2: unknown key `stratgey` at the top\n  help: did you mean `strategy`?",
            "36:8: `cutting.feed` = -3 must be at least 0.01\n  help: Feed in mm/min.",
        ];
        let found = faults(&text);
        assert_eq!(found.len(), expected.len(), "{found:#?}");
        for (found, expected) in found.iter().zip(expected) {
            assert!(found.starts_with(expected), "{found}\n{expected}");
        }
    }

    #[test]
    fn each_single_fault_names_its_line_and_a_remedy() {
        for (line, by, expected) in [
            (
                "kind = \"bull\"",
                "kind = \"bull\"\nbarrel_radius = 85",
                "19:17: a bull tool has no barrel_radius",
            ),
            ("kind = \"bull\"", "kind = \"ball\"", "18:8: a ball tool cannot have R = 10 mm"),
            ("minor_radius = 6 ", "diameter = 32 ", "20:12: the tool is given twice"),
            ("minor_radius = 6 ", "# ", "18:8: a bull tool needs minor_radius"),
            (
                "construction = \"solid\"",
                "construction = \"insert\"",
                "22:16: a tool with inserts needs",
            ),
            ("method = \"jerk\"", "method = \"given\"", "45:10: a job cannot prescribe speeds"),
            ("method = \"jerk\"", "metod = \"jerk\"", "45:1: unknown key `metod` in [motion]"),
            ("along = \"v\"", "along = \"w\"", "30:9: `strategy.along` cannot be \"w\""),
            (
                "direction = \"zigzag\"",
                "feed = 3",
                "31:1: unknown key `feed` in [strategy]\n  help: `feed` belongs in [cutting]",
            ),
            ("faces = \"all\"", "faces = [3, 3]", "8:13: face 3 is named twice"),
            ("faces = \"all\"", "faces = []", "8:9: no face is named"),
            ("length = 120 ", "length = inf ", "21:10: `tool.length` = inf is not a finite number"),
            ("feed = 3000 ", "feed = 3000\nfeed = 3", "37:1: duplicate key"),
            (
                "dialects = [",
                "dialects = [\"g94\", ",
                "49:13: `output.dialects.0` cannot be \"g94\"",
            ),
            ("clearance = 50", "clearance", "14:27: key with no value"),
            (
                "method = \"widest\"",
                "method = \"ball\"",
                "29:10: method \"ball\" is for ball cutters",
            ),
            (
                "method = \"widest\"",
                "method = \"fixed-tilt\"",
                "29:10: method \"fixed-tilt\" needs",
            ),
            (
                "method = \"widest\"",
                "method = \"widest\"\nlead_angle = 5",
                "30:14: method \"widest\" finds the inclination of the tool itself",
            ),
            (
                "method = \"widest\"",
                "method = \"fixed-tilt\"\nlead_angle = 5\ntilt_angle = 20",
                "31:14: only a ball can tilt by 20 deg",
            ),
            (
                "method = \"widest\"",
                "method = \"fixed-tilt\"\nlead_angle = 40",
                "30:14: the tool would be inclined by 40.0 deg",
            ),
            ("faces = \"all\"", "faces = \"all\"\navoid = [2, 2]", "9:13: face 2 is named twice"),
        ] {
            let found = faults(&with(line, by));
            assert!(found[0].starts_with(expected), "{by}: {found:#?}");
            assert!(found[0].contains("help: "), "{by}: no remedy in {found:#?}");
        }
    }

    #[test]
    fn a_file_that_is_something_else_is_named() {
        for (text, expected) in [
            ("{\"degree\": [3, 3]}", "1:1: this is a JSON file, not a job file"),
            ("ISO-10303-21;\nHEADER;", "1:1: this is a STEP file, not a job file"),
            ("solid x\n facet normal 0 0 1", "1:1: this is an STL file"),
            ("\u{0}\u{1}PK", "1:1: this is a binary file"),
            ("%\nN10 G0 X0", "1:1: this is an NC program"),
            ("schema = \"trunnion-machine/1\"", "1:10: this is a machine file, not a job file"),
            ("schema = \"trunnion-job/2\"", "1:10: version 2 of the job file is not supported"),
        ] {
            let found = faults(text);
            assert!(found.len() == 1 && found[0].starts_with(expected), "{found:#?}");
        }
    }

    #[test]
    fn leads_and_tilts_are_read() {
        let text = |by: &str| parse(&with("method = \"widest\"", by)).unwrap().strategy.method;
        let fixed = |lead: f64, tilt: f64| JobPlacement::Fixed {
            lead: lead.to_radians(),
            tilt: tilt.to_radians(),
        };
        assert_eq!(text("method = \"fixed-tilt\"\nlead_angle = 5"), fixed(5.0, 0.0));
        let both = "method = \"fixed-tilt\"\nlead_angle = 5\ntilt_angle = -8";
        assert_eq!(text(both), fixed(5.0, -8.0));
    }

    #[test]
    fn a_job_needs_no_strategy() {
        let (head, _) = EXAMPLE.split_once("[strategy]").unwrap();
        let (_, tail) = EXAMPLE.split_once("[cutting]").unwrap();
        let bare = format!("{head}[cutting]{tail}");
        let found = parse(&bare).unwrap().strategy;
        assert_eq!(found.method, JobPlacement::Widest);
        assert_eq!(found.along, JobFeedDirection::Adaptive);
        let ball = bare
            .replace("kind = \"bull\"", "kind = \"ball\"")
            .replace("major_radius = 10", "major_radius = 0");
        let angle = 10_f64.to_radians();
        assert_eq!(parse(&ball).unwrap().strategy.method, JobPlacement::Leaning { angle });
    }

    #[test]
    fn a_tool_by_diameter_is_the_same_tool() {
        let by_radii = parse(EXAMPLE).unwrap().tool;
        let text = with("major_radius = 10 ", "diameter = 32 # ")
            .replace("minor_radius = 6 ", "corner_radius = 6 # ");
        assert_eq!(parse(&text).unwrap().tool, by_radii);
    }
}
