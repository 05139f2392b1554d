//! Tools as arguments.

use crate::material;
use crate::option_values::{finite, two};
use crate::outcome::Failure;
use crate::post::tools::{self, ToolLength};
use std::path::Path;
use trunnion::cutter::{Cutter, CutterConstruction, CutterSide, CutterSpec};
use trunnion::pipeline;

/// Largest tolerance \[mm\]: rays along the normals reach twice as far from each point of the face.
const LARGEST_TOLERANCE: f64 = 100.0;

/// Reads the largest excess and the deepest gouge \[mm\].
pub(super) fn tolerance(text: &str) -> Result<[f64; 2], String> {
    let [total, gouge] = two(text)?;
    if total > 0.0 && gouge >= 0.0 && total.max(gouge) <= LARGEST_TOLERANCE {
        return Ok([total, gouge]);
    }
    Err(format!(
        "write the largest excess, above 0, and the deepest gouge, at least 0, both up to {LARGEST_TOLERANCE} mm, such as 0.02,0.002"
    ))
}

/// Shape of a tool of which only the length counts.
const LENGTH_ONLY: &str = "R=0,r=1";

/// Use of the shapes of tools.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ToolShape {
    /// The tool meets faces, stock or fixtures: a cutter must be described.
    Needed,
    /// Only axes are audited: the length of the tool is enough.
    LengthOnly,
}

/// Options that describe tools; each may begin with a tool number: `2=R=5,r=1`.
pub(super) struct Toolbox<'a> {
    pub(super) cutter: &'a [String],
    pub(super) shank: &'a [String],
    pub(super) holder: &'a [String],
    pub(super) length: &'a [ToolLength],
    pub(super) shape: ToolShape,
}

/// Splits the tool number off an option.
fn numbered(text: &str) -> (Option<u32>, &str) {
    let Some((number, rest)) = text.split_once('=') else { return (None, text) };
    match number.trim().trim_start_matches(['T', 't']).parse() {
        Ok(number) => (Some(number), rest),
        Err(_) => (None, text),
    }
}

impl Toolbox<'_> {
    /// Returns true if an option has no tool number.
    pub(super) fn has_plain(&self) -> bool {
        let mut texts = [self.cutter, self.shank, self.holder].into_iter().flatten();
        texts.any(|text| numbered(text).0.is_none()) || tools::plain(self.length).is_some()
    }

    /// Returns the numbers of the tools described, in ascending order.
    pub(super) fn numbers(&self) -> Vec<u32> {
        let texts = [self.cutter, self.shank, self.holder].into_iter().flatten();
        let named = texts.filter_map(|text| numbered(text).0);
        let lengths = tools::numbered(self.length).into_iter().map(|tool| tool.number);
        let mut numbers: Vec<u32> = named.chain(lengths).collect();
        numbers.sort_unstable();
        numbers.dedup();
        numbers
    }

    /// Returns the description of a tool: its own options, else those without a number.
    ///
    /// `None` if no option gives its cutter.
    pub(super) fn of(&self, number: Option<u32>) -> Option<ToolDescription<'_>> {
        let own = tools::numbered(self.length).into_iter().find(|tool| Some(tool.number) == number);
        let length = own.map(|tool| tool.length).or(tools::plain(self.length));
        // Where nothing meets the tool, a length stands for a cutter.
        let nominal =
            (self.shape == ToolShape::LengthOnly && length.is_some()).then_some(LENGTH_ONLY);
        Some(ToolDescription {
            cutter: option_of(self.cutter, number).or(nominal)?,
            shank: option_of(self.shank, number),
            holder: option_of(self.holder, number),
            length,
        })
    }
}

/// Returns the last option of a tool, else the last one without a number.
fn option_of(texts: &[String], number: Option<u32>) -> Option<&str> {
    let of = |number: Option<u32>| {
        texts.iter().rev().map(|text| numbered(text)).find(|(known, _)| *known == number)
    };
    of(number).or_else(|| of(None)).map(|(_, text)| text)
}

/// Description of one tool on the command line.
pub(crate) struct ToolDescription<'a> {
    pub(crate) cutter: &'a str,
    pub(crate) shank: Option<&'a str>,
    pub(crate) holder: Option<&'a str>,
    pub(crate) length: Option<f64>,
}

impl ToolDescription<'_> {
    /// Builds the tool. Without a length it ends with its profile, or two diameters above the tip.
    pub(crate) fn cutter(&self) -> Result<Cutter, Failure> {
        let end = self.end()?;
        let spec = self.spec(&end)?;
        let outer = spec.side.diameter().map_or(spec.major + spec.minor, |diameter| 0.5 * diameter);
        let mut shank = profile("--shank", self.shank)?;
        let is_drawn = |path: &Path| material::is_stl(path) || material::is_step(path);
        let holder = match self.holder.filter(|name| is_drawn(Path::new(name))) {
            Some(name) => holder_of(name, self.length.or(end.length))?,
            None => profile("--holder", self.holder)?,
        };
        // The profile is a chain: the shank reaches the lower end of the holder with its last radius.
        if let Some(&[height, _]) = holder.first() {
            let radius = shank.last().map_or(outer, |&[_, radius]| radius);
            shank.push([height, radius]);
        }
        shank.extend(holder);
        let top = shank.last().map_or(preset(&spec, outer), |&[height, _]| height);
        let length = self.length.or(end.length).unwrap_or(top);
        let construction = end.inner.map_or(CutterConstruction::Solid, |inner_cutting_radius| {
            CutterConstruction::Insert { inner_cutting_radius }
        });
        Cutter::new(CutterSpec { length, construction, shank, ..spec })
            .map_err(|faults| Failure::Input(faults.iter().map(ToString::to_string).collect()))
    }

    /// Reads the cutting end.
    fn end(&self) -> Result<CuttingEndText, Failure> {
        let mut end = CuttingEndText::default();
        for entry in self.cutter.split(',') {
            let (name, value) =
                entry.split_once('=').ok_or_else(|| self.wrong("name=value is expected"))?;
            let value =
                finite(value).map_err(|_| self.wrong(&format!("{entry} is not a number")))?;
            let slot = match name.trim() {
                "R" => &mut end.major,
                "r" => &mut end.minor,
                "L" => &mut end.length,
                "D" => &mut end.diameter,
                "taper" => &mut end.taper,
                "barrel" => &mut end.barrel,
                "corner" => &mut end.corner,
                "inner" => &mut end.inner,
                other => {
                    let known = "R, r, L, D, taper, barrel, corner, inner";
                    return Err(self.wrong(&format!("{other} is not one of {known}")));
                }
            };
            if slot.replace(value).is_some() {
                return Err(self.wrong(&format!("{name} is given twice")));
            }
        }
        Ok(end)
    }

    /// Describes the cutting end, by radii or with a side beside its tip arc.
    fn spec(&self, end: &CuttingEndText) -> Result<CutterSpec, Failure> {
        let sides = [end.diameter, end.taper, end.barrel, end.corner];
        if sides.iter().all(Option::is_none) {
            let (Some(major), Some(minor)) = (end.major, end.minor) else {
                return Err(self.wrong("both R and r are needed"));
            };
            return Ok(CutterSpec::of_radii(major, minor));
        }
        let (None, Some(tip), Some(diameter)) = (end.major, end.minor, end.diameter) else {
            return Err(self.wrong("a tapered, barrel or lens cutter needs r and D, and has no R"));
        };
        let angle = end.taper.map(f64::to_radians);
        match (angle, end.barrel, end.corner) {
            (Some(angle), None, None) => Ok(CutterSpec::taper(tip, angle, diameter)),
            (None, Some(barrel), None) => Ok(CutterSpec::barrel(tip, barrel, diameter)),
            (Some(angle), Some(barrel), None) => {
                Ok(CutterSpec::conical_barrel(tip, barrel, angle, diameter))
            }
            (None, None, Some(corner)) => Ok(CutterSpec::lens(tip, corner, diameter)),
            _ => Err(self.wrong("beside r and D, give taper, barrel, both of them, or corner")),
        }
    }

    fn wrong(&self, what: &str) -> Failure {
        let help = "for instance --cutter R=10,r=6 or R=0,r=3,L=80; tapered r=1,taper=5,D=10, barrel r=2,barrel=85,D=12, \
                    conical barrel with both, lens r=85,corner=1,D=12";
        Failure::input(format!("--cutter {}: {what}\n  help: {help}", self.cutter))
    }
}

/// Returns the length of a tool that is given without one: two diameters, or the preset where a side may be longer \[mm\].
fn preset(spec: &CutterSpec, radius: f64) -> f64 {
    if spec.side == CutterSide::Straight { 4.0 * radius } else { spec.length }
}

/// Names and values of `--cutter`: mm, and degrees for `taper`.
#[derive(Debug, Default)]
struct CuttingEndText {
    major: Option<f64>,
    minor: Option<f64>,
    length: Option<f64>,
    diameter: Option<f64>,
    taper: Option<f64>,
    barrel: Option<f64>,
    corner: Option<f64>,
    inner: Option<f64>,
}

/// Reads a holder from triangles, for a tool of a length \[mm\].
fn holder_of(name: &str, length: Option<f64>) -> Result<Vec<[f64; 2]>, Failure> {
    let wrong = |what: String| Failure::input(format!("--holder {name}: {what}"));
    let length = length.ok_or_else(|| {
        let help = "give --tool-length, or L in --cutter";
        wrong(format!("its z counts from the gauge point: the tool needs a length\n  help: {help}"))
    })?;
    let mesh = material::holder_mesh(Path::new(name)).map_err(wrong)?;
    pipeline::holder_profile(&mesh, length).map_err(|error| wrong(error.to_string()))
}

/// Reads a profile: `30:12.5,60:25`.
fn profile(option: &str, text: Option<&str>) -> Result<Vec<[f64; 2]>, Failure> {
    let Some(text) = text else { return Ok(Vec::new()) };
    let wrong = || {
        let help = "give height above the tip and radius, from the lowest point up: 30:12.5,60:25";
        Failure::input(format!("{option} {text}: not a profile\n  help: {help}"))
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
    fn numbers_separate_tools() {
        let words = |texts: &[&str]| texts.iter().map(|text| (*text).to_owned()).collect();
        let cutter: Vec<String> = words(&["R=10,r=6", "2=R=5,r=1,L=80"]);
        let shank: Vec<String> = words(&["T3=30:4"]);
        let length = [ToolLength::Of(1, 120.0), ToolLength::Of(3, 90.0)];
        let shape = ToolShape::Needed;
        let all = Toolbox { cutter: &cutter, shank: &shank, holder: &[], length: &length, shape };
        assert_eq!(all.numbers(), [1, 2, 3]);
        let tool = |number| all.of(Some(number)).unwrap().cutter().ok().unwrap();
        let [a, b, c] = [1, 2, 3].map(tool);
        assert_eq!((a.length(), b.length(), c.length()), (120.0, 80.0, 90.0));
        assert_eq!((a.major(), b.major(), c.major()), (10.0, 5.0, 10.0));
        assert_eq!([a.spec().shank.len(), c.spec().shank.len()], [0, 1]);
        let bare = Toolbox { cutter: &cutter[1..], ..all };
        assert!(bare.of(Some(1)).is_none());
        let bare = Toolbox { shape: ToolShape::LengthOnly, ..bare };
        let length = bare.of(Some(1)).unwrap().cutter().ok().unwrap().length();
        assert!((length - 120.0).abs() < 1e-12);
        assert!(bare.of(None).is_none(), "neither cutter nor length");
    }

    #[test]
    fn a_tool_is_put_together_from_its_parts() {
        let described = |length| ToolDescription {
            cutter: "R=10,r=6",
            shank: Some("30:12.5"),
            holder: Some("60:25,90:30"),
            length,
        };
        let cutter = described(Some(120.0)).cutter().ok().unwrap();
        let shank = vec![[30.0, 12.5], [60.0, 12.5], [60.0, 25.0], [90.0, 30.0]];
        assert_eq!((cutter.length(), &cutter.spec().shank), (120.0, &shank));
        assert!((described(None).cutter().ok().unwrap().length() - 90.0).abs() < 1e-12);
        assert!(ToolDescription { cutter: "R=10,r=six", ..described(None) }.cutter().is_err());
        assert!(ToolDescription { cutter: "R=10,R=9,r=1", ..described(None) }.cutter().is_err());
        let kind = |cutter| {
            ToolDescription { cutter, shank: None, holder: None, length: Some(90.0) }
                .cutter()
                .ok()
                .map(|cutter| cutter.kind().name())
        };
        assert_eq!(kind("r=1,taper=5,D=10"), Some("taper"));
        assert_eq!(kind("r=2,barrel=85,D=12"), Some("barrel"));
        assert_eq!(kind("r=2,barrel=250,taper=20,D=12"), Some("conical-barrel"));
        assert_eq!(kind("r=85,corner=1,D=12"), Some("lens"));
        assert_eq!(kind("r=85,corner=1,taper=3,D=12"), None);
        assert_eq!(kind("R=1,r=2,D=12"), None);
        assert!(ToolDescription { shank: Some("30"), ..described(None) }.cutter().is_err());
    }
}
