//! The job's `[stock]` and `[[fixture]]`.

use super::super::document::Document;
use super::raw::{RawFixture, RawSolid, RawSolidKind, RawStock};
use crate::machine::Setup;
use nalgebra::{Isometry3, Point3};
use std::fmt;

/// Default chord tolerance of the triangles that represent a STEP solid \[mm\].
pub const STEP_CHORD: f64 = 0.01;

/// Stock in the workpiece frame.
#[derive(Debug, Clone, PartialEq)]
pub enum JobStock {
    /// The part with this much left on \[mm\].
    Offset {
        /// Thickness \[mm\].
        thickness: f64,
    },
    /// A solid of its own shape.
    Solid(JobSolid),
}

/// Fixture that the tool must not touch.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct JobFixture {
    /// Name in findings: as given, or the solid in words.
    pub name: String,
    /// Shape and position.
    pub solid: JobSolid,
}

/// Solid in the workpiece frame.
#[derive(Debug, Clone, PartialEq)]
pub enum JobSolid {
    /// Box parallel to the workpiece frame.
    Box {
        /// Corner with the smallest coordinates \[mm\].
        min: Point3<f64>,
        /// Corner with the largest coordinates \[mm\].
        max: Point3<f64>,
    },
    /// Upright cylinder.
    Cylinder {
        /// Centre of the lower end \[mm\].
        base: Point3<f64>,
        /// Radius \[mm\].
        radius: f64,
        /// Height \[mm\].
        height: f64,
    },
    /// Interior of a closed mesh.
    Stl {
        /// STL file in mm, as written in the job.
        file: String,
        /// The part's coordinates from those of the file.
        place: Isometry3<f64>,
    },
    /// Solids of a STEP file.
    Step {
        /// STEP file, as written in the job.
        file: String,
        /// Chord tolerance of the triangles that represent them \[mm\].
        chord: f64,
        /// The part's coordinates from those of the file.
        place: Isometry3<f64>,
    },
}

/// Returns the transformation from the coordinates of a file to those of the part: a rotation by
/// `angles` \[rad\] about the fixed x, then y, then z, then a translation to `origin` \[mm\].
pub fn placement(origin: [f64; 3], angles: [f64; 3]) -> Isometry3<f64> {
    let Setup { origin, rotation, .. } = Setup::new(origin.into(), angles, 0.0);
    Isometry3::from_parts(origin.into(), rotation.into())
}

impl JobStock {
    /// Returns the solid; `None` for an offset of the part.
    pub fn solid(&self) -> Option<&JobSolid> {
        match self {
            Self::Offset { .. } => None,
            Self::Solid(solid) => Some(solid),
        }
    }
}

impl JobSolid {
    /// Returns its file as written in the job.
    pub fn file(&self) -> Option<&str> {
        match self {
            Self::Box { .. } | Self::Cylinder { .. } => None,
            Self::Stl { file, .. } | Self::Step { file, .. } => Some(file),
        }
    }

    /// Returns the transformation from the coordinates of its file to those of the part.
    pub fn place(&self) -> Isometry3<f64> {
        match self {
            Self::Box { .. } | Self::Cylinder { .. } => Isometry3::identity(),
            Self::Stl { place, .. } | Self::Step { place, .. } => *place,
        }
    }

    /// Returns the chord tolerance of its triangles \[mm\]; `None` except for a STEP file.
    pub fn chord(&self) -> Option<f64> {
        match self {
            Self::Step { chord, .. } => Some(*chord),
            _ => None,
        }
    }

    pub(super) fn set_chord(&mut self, value: f64) {
        if let Self::Step { chord, .. } = self {
            *chord = value;
        }
    }
}

impl fmt::Display for JobSolid {
    /// Writes the solid as an argument of the command line.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Box { min: a, max: b } => {
                write!(f, "box:{},{},{},{},{},{}", a.x, a.y, a.z, b.x, b.y, b.z)
            }
            Self::Cylinder { base: p, radius, height } => {
                write!(f, "cyl:{},{},{},{radius},{height}", p.x, p.y, p.z)
            }
            Self::Stl { file, .. } | Self::Step { file, .. } => f.write_str(file),
        }
    }
}

/// Keys that belong to a kind of solid.
struct KindKeys {
    kind: &'static str,
    /// Required keys.
    needed: &'static [&'static str],
    /// Optional keys.
    others: &'static [&'static str],
}

/// Table whose `kind` decides its other keys.
struct KindTable<'a> {
    /// Description for messages.
    what: &'a str,
    /// Dotted path of the table.
    path: &'a str,
    /// Keys that only this table knows; true if present.
    more: &'a [(&'a str, bool)],
}

pub(super) fn stock(raw: &RawStock, doc: &mut Document<'_>) -> Option<JobStock> {
    let more = [("thickness", raw.thickness.is_some())];
    let table = KindTable { what: "stock", path: "stock", more: &more };
    if let Some(kind) = raw.kind.solid() {
        return table.solid(kind, &raw.solid, doc).map(JobStock::Solid);
    }
    // An offset follows the part: it has a thickness, and no shape of its own.
    let rule = KindKeys { kind: "offset", needed: &["thickness"], others: &[] };
    table.keys(&raw.solid, &rule, doc);
    Some(JobStock::Offset { thickness: raw.thickness? })
}

/// Reads all fixtures; the faults of all are reported together.
pub(super) fn fixtures(doc: &mut Document<'_>) -> Option<Vec<JobFixture>> {
    let mut all = Vec::new();
    for (number, raw) in doc.list::<RawFixture>("fixture").into_iter().enumerate() {
        // Paths count from 0, as in the tree; messages show the line instead.
        let path = format!("fixture.{number}");
        let table = KindTable { what: "a fixture", path: &path, more: &[] };
        let fixture = raw.and_then(|raw| {
            let solid = table.solid(raw.kind, &raw.solid, doc)?;
            Some(JobFixture { name: raw.name.unwrap_or_else(|| solid.to_string()), solid })
        });
        all.push(fixture);
    }
    // One faulty fixture is enough to refuse the job, but only after all were read.
    all.into_iter().collect()
}

impl KindTable<'_> {
    fn solid(
        &self,
        kind: RawSolidKind,
        raw: &RawSolid,
        doc: &mut Document<'_>,
    ) -> Option<JobSolid> {
        let rule = match kind {
            RawSolidKind::Box => KindKeys { kind: "box", needed: &["min", "max"], others: &[] },
            RawSolidKind::Cylinder => {
                KindKeys { kind: "cylinder", needed: &["base", "radius", "height"], others: &[] }
            }
            RawSolidKind::Stl => {
                KindKeys { kind: "stl", needed: &["file"], others: &["origin", "rotation"] }
            }
            RawSolidKind::Step => KindKeys {
                kind: "step",
                needed: &["file"],
                others: &["chord", "origin", "rotation"],
            },
        };
        // The schema cannot express which keys a kind needs: all of them are optional there.
        self.keys(raw, &rule, doc);
        let angles = raw.rotation.unwrap_or_default().map(f64::to_radians);
        let place = placement(raw.origin.unwrap_or_default(), angles);
        Some(match kind {
            RawSolidKind::Box => {
                let [min, max] = [Point3::from(raw.min?), Point3::from(raw.max?)];
                // A flat or inverted box encloses nothing that rays could hit.
                if (0..3).any(|axis| min[axis] >= max[axis]) {
                    let message = format!("the box from {min} to {max} mm is empty");
                    let help = "every coordinate of max is above that of min";
                    doc.fault(&format!("{}.max", self.path), message, help);
                }
                JobSolid::Box { min, max }
            }
            RawSolidKind::Cylinder => {
                let base = Point3::from(raw.base?);
                JobSolid::Cylinder { base, radius: raw.radius?, height: raw.height? }
            }
            RawSolidKind::Stl => JobSolid::Stl { file: raw.file.clone()?, place },
            RawSolidKind::Step => {
                let chord = raw.chord.unwrap_or(STEP_CHORD);
                JobSolid::Step { file: raw.file.clone()?, chord, place }
            }
        })
    }

    /// Reports keys that do not belong to the kind, and required ones that are missing.
    fn keys(&self, raw: &RawSolid, rule: &KindKeys, doc: &mut Document<'_>) {
        let KindKeys { kind, needed, others } = *rule;
        let of_all = [
            ("min", raw.min.is_some()),
            ("max", raw.max.is_some()),
            ("base", raw.base.is_some()),
            ("radius", raw.radius.is_some()),
            ("height", raw.height.is_some()),
            ("file", raw.file.is_some()),
            ("chord", raw.chord.is_some()),
            ("origin", raw.origin.is_some()),
            ("rotation", raw.rotation.is_some()),
        ];
        let Self { what, path, more } = self;
        let wanted = needed.join(", ");
        for &(key, is_given) in more.iter().chain(&of_all) {
            if is_given && !needed.contains(&key) && !others.contains(&key) {
                let message = format!("{what} of kind {kind:?} has no {key}");
                let help = format!("remove it; {kind:?} needs {wanted}");
                doc.fault(&format!("{path}.{key}"), message, help);
            } else if !is_given && needed.contains(&key) {
                let message = format!("{what} of kind {kind:?} needs {key}");
                // A missing key has no position: the kind that requires it is blamed.
                let unit = if key == "file" { "" } else { ", in mm" };
                doc.fault(
                    &format!("{path}.kind"),
                    message,
                    format!("{kind:?} needs {wanted}{unit}"),
                );
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::data::JobFile;
    use super::super::parse;
    use super::*;

    /// The last line of it, 52, stands in [verify].
    const EXAMPLE: &str = include_str!("../../../../../examples/bezier-patch/job.toml");

    fn faults(more: &str) -> Vec<String> {
        let faults = parse(&format!("{EXAMPLE}{more}")).err();
        let faults = faults.unwrap_or_else(|| panic!("no fault in\n{more}"));
        faults.iter().map(ToString::to_string).collect()
    }

    #[test]
    fn fixtures_are_written_as_stock_is() {
        let solids = [
            "kind = \"box\"\nmin = [1, 2, 3]\nmax = [4, 5.5, 6]\n",
            "kind = \"cylinder\"\nbase = [0, 0, -4]\nradius = 3\nheight = 2\n",
            "kind = \"stl\"\nfile = \"clamp.stl\"\n",
            "kind = \"step\"\nfile = \"vise.step\"\n",
            "kind = \"step\"\nfile = \"vise.step\"\nchord = 0.05\n",
        ];
        let fixtures = solids.map(|solid| format!("[[fixture]]\n{solid}")).concat();
        let job = parse(&format!("{EXAMPLE}fixture_clearance = 0.5\n{fixtures}")).unwrap();
        assert!((job.fixture_clearance - 0.5).abs() < 1e-12);
        let chords = |job: &JobFile| {
            job.chords().into_iter().map(|of| (of.solid, of.chord)).collect::<Vec<_>>()
        };
        let vise = |chord: f64| ("vise.step".to_owned(), chord);
        assert_eq!(chords(&job), [vise(STEP_CHORD), vise(0.05)]);
        let names: Vec<&str> = job.fixtures.iter().map(|fixture| fixture.name.as_str()).collect();
        let expected =
            ["box:1,2,3,4,5.5,6", "cyl:0,0,-4,3,2", "clamp.stl", "vise.step", "vise.step"];
        assert_eq!(names, expected);
        let each: Vec<_> = job.fixtures.iter().map(|fixture| fixture.solid.chord()).collect();
        assert_eq!(each, [None, None, None, Some(STEP_CHORD), Some(0.05)]);
        assert_eq!(job.places.get("fixture.4.chord").line, 72);
        for (solid, fixture) in solids.iter().zip(&job.fixtures) {
            let job = parse(&format!("{EXAMPLE}[stock]\n{solid}")).unwrap();
            assert_eq!(job.stock.as_ref().and_then(JobStock::solid), Some(&fixture.solid));
            assert_eq!((job.fixtures.len(), job.fixture_clearance), (0, 0.0));
        }
        assert_eq!(chords(&job.with_chord(0.002)), [vise(0.002), vise(0.002)]);
        let named =
            parse(&format!("{EXAMPLE}[[fixture]]\nname = \"vise\"\n{}", solids[0])).unwrap();
        assert_eq!(named.fixtures[0].name, "vise");
    }

    #[test]
    fn solids_of_files_have_places_as_the_setup_has() {
        let at = |more: &str| {
            let text = format!("{EXAMPLE}[[fixture]]\nkind = \"stl\"\nfile = \"a.stl\"\n{more}");
            parse(&text).unwrap().fixtures[0].solid.place() * Point3::new(1.0, 2.0, 3.0)
        };
        assert_eq!(at(""), Point3::new(1.0, 2.0, 3.0));
        assert_eq!(at("origin = [10, 0, -5]\n"), Point3::new(11.0, 2.0, -2.0));
        // About x: (1, -3, 2); then about z: (3, 1, 2).
        let turned = at("origin = [10, 0, -5]\nrotation = [90, 0, 90]\n");
        assert!((turned - Point3::new(13.0, 1.0, -3.0)).norm() < 1e-12, "{turned}");
        let wrong = "[[fixture]]\nkind = \"cylinder\"\nbase = [0, 0, 0]\nradius = 1\nheight = 1\norigin = [1, 2, 3]\n\
            [[fixture]]\nkind = \"stl\"\nfile = \"a.stl\"\nrotation = [400, 0, 0]\n";
        let found = faults(wrong);
        assert!(
            found[0].starts_with("58:10: a fixture of kind \"cylinder\" has no origin"),
            "{found:?}"
        );
        assert!(found[1].contains("rotation") && found[1].contains("360"), "{found:?}");
    }

    #[test]
    fn faults_of_all_fixtures_come_together() {
        let text = "[[fixture]]\nkind = \"box\"\nmin = [0, 0, 0]\nmax = [1, 0, 1]\nradius = 2\n\
            [[fixture]]\nkind = \"step\"\nfle = \"vise.step\"\n\
            [[fixture]]\nkind = \"stl\"\nchord = -0.5\nclearance = 1\n\
            [[fixture]]\nkind = \"stl\"\nfile = \"a.stl\"\nchord = 0.5\n\
            [[fixture]]\nkind = \"offset\"\nthickness = 1\n";
        let expected = [
            "56:7: the box from {0, 0, 0} to {1, 0, 1} mm is empty",
            "57:10: a fixture of kind \"box\" has no radius\n  help: remove it",
            "60:1: unknown key `fle` in [[fixture]]\n  help: did you mean `file`?",
            "63:9: `fixture.2.chord` = -0.5 must be above 0\n  help: Largest distance of the triangles",
            "64:1: unknown key `clearance` in [[fixture]]\n  help: did you mean `fixture_clearance` in [verify]?",
            "68:9: a fixture of kind \"stl\" has no chord",
            "70:8: `fixture.4.kind` cannot be \"offset\"",
            "71:1: unknown key `thickness` in [[fixture]]\n  help: `thickness` belongs in [stock]",
        ];
        let found = faults(text);
        assert_eq!(found.len(), expected.len(), "{found:#?}");
        for (found, expected) in found.iter().zip(expected) {
            assert!(found.starts_with(expected), "{found}\n{expected}");
        }
        for (more, expected) in [
            (
                "[fixture]\n",
                "53:2: `fixture` must be a list, not a table\n  help: write [[fixture]]",
            ),
            (
                "[[fixtures]]\n",
                "53:3: unknown key `fixtures` at the top\n  help: did you mean `fixture`?",
            ),
            (
                "fixture = 3\n",
                "53:1: unknown key `fixture` in [verify]\n  help: it is a table of its own: [[fixture]]",
            ),
            ("[[fixture]]\n", "53:1: missing key `kind` in [[fixture]]"),
            ("[[fixture]]\nkind = \"stl\"\n", "54:8: a fixture of kind \"stl\" needs file"),
            (
                "clearance = 1\n",
                "53:1: unknown key `clearance` in [verify]\n  help: did you mean `fixture_c",
            ),
            (
                "fixture_clearance = -1\n",
                "53:21: `verify.fixture_clearance` = -1 must be at least 0",
            ),
            ("[stock]\nkind = \"box\"\ncell = 1\n", "54:8: stock of kind \"box\" needs max"),
        ] {
            let found = faults(more);
            assert!(found[0].starts_with(expected), "{found:#?}\n{expected}");
            assert!(found[0].contains("help: "), "{found:#?}");
        }
    }
}
