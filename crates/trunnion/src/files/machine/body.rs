//! The machine's `[[body]]` tables.

use super::super::document::Document;
use super::raw::{RawBody, RawBodyKind};
use crate::machine::{BodyShape, MachineBody, Setup};
use nalgebra::{Isometry3, Point3};

/// Default chord tolerance of the triangles that represent a STEP solid \[mm\].
const CHORD: f64 = 0.1;

/// Keys that belong to each kind: those that it needs, and those that it may have.
const KEYS: [(RawBodyKind, &str, &[&str], &[&str]); 4] = [
    (RawBodyKind::Box, "box", &["min", "max"], &[]),
    (RawBodyKind::Cylinder, "cylinder", &["base", "radius", "height"], &["axis"]),
    (RawBodyKind::Stl, "stl", &["file"], &["origin", "rotation"]),
    (RawBodyKind::Step, "step", &["file"], &["chord", "origin", "rotation"]),
];

/// Factors from the units of the file to mm and rad.
#[derive(Debug, Clone, Copy)]
pub(super) struct BodyScale {
    pub(super) length: f64,
    pub(super) angle: f64,
}

/// Reads the bodies; `None` if one is faulty.
pub(super) fn bodies(scale: BodyScale, doc: &mut Document<'_>) -> Option<Vec<MachineBody>> {
    let mut all = Vec::new();
    for (number, raw) in doc.list::<RawBody>("body").into_iter().enumerate() {
        let body = raw.and_then(|raw| {
            keys(&raw, number, doc)?;
            let shape = shape(&raw, scale)?;
            Some(MachineBody { name: raw.name, link: raw.link, shape, touches: raw.touches })
        });
        all.push(body);
    }
    // One faulty body is enough to refuse the file, but only after all were read.
    all.into_iter().collect()
}

/// Checks that a body has the keys of its kind and no others.
fn keys(raw: &RawBody, number: usize, doc: &mut Document<'_>) -> Option<()> {
    let (_, kind, needed, others) = KEYS.iter().find(|(kind, ..)| *kind == raw.kind)?;
    let given = [
        ("min", raw.min.is_some()),
        ("max", raw.max.is_some()),
        ("base", raw.base.is_some()),
        ("axis", raw.axis.is_some()),
        ("radius", raw.radius.is_some()),
        ("height", raw.height.is_some()),
        ("file", raw.file.is_some()),
        ("chord", raw.chord.is_some()),
        ("origin", raw.origin.is_some()),
        ("rotation", raw.rotation.is_some()),
    ];
    let mut sound = true;
    for (key, is_given) in given {
        let wrong = match (needed.contains(&key), others.contains(&key), is_given) {
            (true, _, false) => format!("a body of kind \"{kind}\" needs {key}"),
            (false, false, true) => format!("a body of kind \"{kind}\" has no {key}"),
            _ => continue,
        };
        sound = false;
        let path =
            if is_given { format!("body.{number}.{key}") } else { format!("body.{number}.kind") };
        let all = needed.iter().chain(*others).copied().collect::<Vec<_>>().join(", ");
        doc.fault(&path, wrong, format!("its keys are {all}"));
    }
    sound.then_some(())
}

fn shape(raw: &RawBody, scale: BodyScale) -> Option<BodyShape> {
    let point = |of: [f64; 3]| Point3::from(of.map(|x| x * scale.length));
    let file = || {
        let origin = point(raw.origin.unwrap_or_default()).coords;
        let angles = raw.rotation.unwrap_or_default().map(|angle| angle * scale.angle);
        let Setup { origin, rotation, .. } = Setup::new(origin, angles, 0.0);
        let place = Isometry3::from_parts(origin.into(), rotation.into());
        let chord = raw.chord.map_or(CHORD, |chord| chord * scale.length);
        Some(BodyShape::File { file: raw.file.clone()?, place, chord })
    };
    match raw.kind {
        RawBodyKind::Box => Some(BodyShape::Box { min: point(raw.min?), max: point(raw.max?) }),
        RawBodyKind::Cylinder => Some(BodyShape::Cylinder {
            base: point(raw.base?),
            axis: raw.axis.unwrap_or([0.0, 0.0, 1.0]),
            radius: raw.radius? * scale.length,
            height: raw.height? * scale.length,
        }),
        RawBodyKind::Stl | RawBodyKind::Step => file(),
    }
}
