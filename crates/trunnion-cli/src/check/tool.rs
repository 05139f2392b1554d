//! Tools and numbers as arguments.

use crate::outcome::Failure;
use crate::post::tools::{self, ToolLength};
use trunnion::cutter::{Cutter, CutterConstruction, CutterKind, CutterSpec};

pub(super) fn finite(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err("a finite number is wanted".into()),
    }
}

pub(super) fn positive(text: &str) -> Result<f64, String> {
    finite(text).ok().filter(|value| *value > 0.0).ok_or("a number above 0 is wanted".into())
}

pub(super) fn not_negative(text: &str) -> Result<f64, String> {
    finite(text).ok().filter(|value| *value >= 0.0).ok_or("0 or a number above it is wanted".into())
}

fn numbers<const N: usize>(text: &str, wanted: &str) -> Result<[f64; N], String> {
    let numbers: Result<Vec<f64>, String> = text.split(',').map(finite).collect();
    numbers?.try_into().map_err(|_| format!("{wanted} numbers separated by commas are wanted"))
}

pub(super) fn three(text: &str) -> Result<[f64; 3], String> {
    numbers(text, "three")
}

/// Largest tolerance \[mm\]: the tool is looked for twice as far off each place of the face.
const LARGEST_TOLERANCE: f64 = 100.0;

/// Most material left, and deepest gouge.
pub(super) fn tolerance(text: &str) -> Result<[f64; 2], String> {
    let [total, gouge] = numbers(text, "two")?;
    if total > 0.0 && gouge >= 0.0 && total.max(gouge) <= LARGEST_TOLERANCE {
        return Ok([total, gouge]);
    }
    Err(format!(
        "most material left above 0 and deepest gouge at least 0, up to {LARGEST_TOLERANCE} mm, are wanted, such as 0.02,0.002"
    ))
}

/// Options of which each may have a number in front: `2=R=5,r=1`.
pub(super) struct Toolbox<'a> {
    pub(super) cutter: &'a [String],
    pub(super) shank: &'a [String],
    pub(super) holder: &'a [String],
    pub(super) length: &'a [ToolLength],
}

/// A number in front of what it is of.
fn numbered(text: &str) -> (Option<u32>, &str) {
    let Some((number, rest)) = text.split_once('=') else { return (None, text) };
    match number.trim().trim_start_matches(['T', 't']).parse() {
        Ok(number) => (Some(number), rest),
        Err(_) => (None, text),
    }
}

impl Toolbox<'_> {
    /// Whether something is told without a number.
    pub(super) fn has_plain(&self) -> bool {
        let mut texts = [self.cutter, self.shank, self.holder].into_iter().flatten();
        texts.any(|text| numbered(text).0.is_none()) || tools::plain(self.length).is_some()
    }

    /// Tools that are told by number.
    pub(super) fn numbers(&self) -> Vec<u32> {
        let texts = [self.cutter, self.shank, self.holder].into_iter().flatten();
        let named = texts.filter_map(|text| numbered(text).0);
        let lengths = tools::numbered(self.length).into_iter().map(|(number, _)| number);
        let mut numbers: Vec<u32> = named.chain(lengths).collect();
        numbers.sort_unstable();
        numbers.dedup();
        numbers
    }

    /// What is told of a tool, or of all that have no word of their own; `None` without a cutter.
    pub(super) fn of(&self, number: Option<u32>) -> Option<Said<'_>> {
        let own =
            tools::numbered(self.length).into_iter().find(|(known, _)| Some(*known) == number);
        Some(Said {
            cutter: word(self.cutter, number)?,
            shank: word(self.shank, number),
            holder: word(self.holder, number),
            length: own.map(|(_, length)| length).or(tools::plain(self.length)),
        })
    }
}

/// The last word of a tool, or that of all.
fn word(texts: &[String], number: Option<u32>) -> Option<&str> {
    let of = |number: Option<u32>| {
        texts.iter().rev().map(|text| numbered(text)).find(|(known, _)| *known == number)
    };
    of(number).or_else(|| of(None)).map(|(_, text)| text)
}

/// What the command line says about the tool.
pub(super) struct Said<'a> {
    pub(super) cutter: &'a str,
    pub(super) shank: Option<&'a str>,
    pub(super) holder: Option<&'a str>,
    pub(super) length: Option<f64>,
}

impl Said<'_> {
    /// The tool; without a length it is taken to end where its profile does, or twice its diameter up.
    pub(super) fn cutter(&self) -> Result<Cutter, Failure> {
        let Radii { major, minor, length, inner } = self.radii()?;
        let mut shank = profile("--shank", self.shank)?;
        let holder = profile("--holder", self.holder)?;
        if let Some(&[height, _]) = holder.first() {
            let radius = shank.last().map_or(major + minor, |&[_, radius]| radius);
            shank.push([height, radius]);
        }
        shank.extend(holder);
        let top = shank.last().map_or(4.0 * (major + minor), |&[height, _]| height);
        let length = self.length.or(length).unwrap_or(top);
        let kind = match (major > 0.0, minor > 0.0) {
            (true, true) => CutterKind::Bull,
            (true, false) => CutterKind::Flat,
            (false, _) => CutterKind::Ball,
        };
        let construction = inner.map_or(CutterConstruction::Solid, |inner_cutting_radius| {
            CutterConstruction::Insert { inner_cutting_radius }
        });
        Cutter::new(CutterSpec { kind, major, minor, length, construction, shank })
            .map_err(|faults| Failure::Input(faults.iter().map(ToString::to_string).collect()))
    }

    fn radii(&self) -> Result<Radii, Failure> {
        let wrong = |what: &str| {
            let help = "for instance --cutter R=10,r=6 or R=0,r=3,L=80";
            Failure::input(format!("--cutter {}: {what}\n  help: {help}", self.cutter))
        };
        let (mut major, mut minor, mut length, mut inner) = (None, None, None, None);
        for entry in self.cutter.split(',') {
            let (name, value) =
                entry.split_once('=').ok_or_else(|| wrong("name=value is wanted"))?;
            let value = finite(value).map_err(|_| wrong(&format!("{entry} is no number")))?;
            let place = match name.trim() {
                "R" => &mut major,
                "r" => &mut minor,
                "L" => &mut length,
                "inner" => &mut inner,
                other => return Err(wrong(&format!("{other} is none of R, r, L, inner"))),
            };
            if place.replace(value).is_some() {
                return Err(wrong(&format!("{name} stands there twice")));
            }
        }
        let (Some(major), Some(minor)) = (major, minor) else {
            return Err(wrong("both R and r are needed"));
        };
        Ok(Radii { major, minor, length, inner })
    }
}

struct Radii {
    major: f64,
    minor: f64,
    length: Option<f64>,
    inner: Option<f64>,
}

/// `30:12.5,60:25`.
fn profile(option: &str, text: Option<&str>) -> Result<Vec<[f64; 2]>, Failure> {
    let Some(text) = text else { return Ok(Vec::new()) };
    let wrong = || {
        let help = "height above the tip and radius, from below up: 30:12.5,60:25";
        Failure::input(format!("{option} {text}: no profile\n  help: {help}"))
    };
    let entry = |entry: &str| {
        let (height, radius) = entry.split_once(':')?;
        Some([finite(height).ok()?, finite(radius).ok()?])
    };
    text.split(',').map(|part| entry(part).ok_or_else(wrong)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tools_are_told_apart_by_their_numbers() {
        let words = |texts: &[&str]| texts.iter().map(|text| (*text).to_owned()).collect();
        let cutter: Vec<String> = words(&["R=10,r=6", "2=R=5,r=1,L=80"]);
        let shank: Vec<String> = words(&["T3=30:4"]);
        let length = [ToolLength::Of(1, 120.0), ToolLength::Of(3, 90.0)];
        let all = Toolbox { cutter: &cutter, shank: &shank, holder: &[], length: &length };
        assert_eq!(all.numbers(), [1, 2, 3]);
        let tool = |number| all.of(Some(number)).unwrap().cutter().ok().unwrap();
        let [a, b, c] = [1, 2, 3].map(tool);
        assert_eq!((a.length(), b.length(), c.length()), (120.0, 80.0, 90.0));
        assert_eq!((a.major(), b.major(), c.major()), (10.0, 5.0, 10.0));
        assert_eq!([a.spec().shank.len(), c.spec().shank.len()], [0, 1]);
        assert!(Toolbox { cutter: &cutter[1..], ..all }.of(Some(1)).is_none());
    }

    #[test]
    fn a_tool_is_put_together_from_its_parts() {
        let said = |length| Said {
            cutter: "R=10,r=6",
            shank: Some("30:12.5"),
            holder: Some("60:25,90:30"),
            length,
        };
        let cutter = said(Some(120.0)).cutter().ok().unwrap();
        let shank = vec![[30.0, 12.5], [60.0, 12.5], [60.0, 25.0], [90.0, 30.0]];
        assert_eq!((cutter.length(), &cutter.spec().shank), (120.0, &shank));
        assert!((said(None).cutter().ok().unwrap().length() - 90.0).abs() < 1e-12);
        assert!(Said { cutter: "R=10,r=six", ..said(None) }.cutter().is_err());
        assert!(Said { cutter: "R=10,R=9,r=1", ..said(None) }.cutter().is_err());
        assert!(Said { shank: Some("30"), ..said(None) }.cutter().is_err());
    }
}
