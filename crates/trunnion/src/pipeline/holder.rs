//! Holders from triangles, as profiles of revolution.
//!
//! A holder turns with the spindle: what it must keep clear is the body of revolution around it, whatever flats and slots it
//! has. An edge of a triangle is straight, so its distance from the axis is a convex function of the height, below the chord
//! between its ends. The profile is the largest of all chords.

use crate::files::job::{HolderFile, JobFile};
use crate::math;
use crate::types::{Diagnostic, Diagnostics, Mesh};
use crate::verify::{Fixture, Solid, VerifyError};

/// Largest distance of a profile from the body of revolution along one edge, and from its own corners \[mm\].
const TOLERANCE: f64 = 0.01;

/// Heights nearer to each other count as one \[mm\].
const ALIKE: f64 = 1e-6;

/// Most heights at which a profile may bend before it is made simpler.
const MOST_HEIGHTS: usize = 2000;

/// Least radius of a profile \[mm\]: a cutter has no point.
const LEAST_RADIUS: f64 = 0.01;

/// Most halvings of an edge.
const HALVINGS: u32 = 12;

impl JobFile {
    /// Sets the profiles of holders that are in files; `mesh_of` returns the triangles in a file \[mm\]. Each file is taken out
    /// of its tool.
    ///
    /// # Errors
    ///
    /// One diagnostic for each file that cannot be used, at its line.
    pub fn with_holders(
        mut self,
        mut mesh_of: impl FnMut(&str) -> Result<Mesh, String>,
    ) -> Result<Self, Diagnostics> {
        let mut faults = Vec::new();
        let operations = self.operations.iter_mut().map(|operation| &mut operation.tool);
        let tools = std::iter::once(&mut self.tool).chain(&mut self.other_tools);
        for tool in tools.chain(operations) {
            let Some(file) = tool.holder_file.take() else { continue };
            let profile = mesh_of(&file.name).and_then(|mesh| {
                holder_profile(&mesh, tool.length).map_err(|error| error.to_string())
            });
            let below = tool.shank.last().map_or(0.0, |[height, _]| *height);
            match profile {
                Ok(profile) if profile.first().is_none_or(|[height, _]| *height < below) => {
                    let start = profile.first().map_or(0.0, |[height, _]| *height);
                    let what = format!(
                        "{}: the holder begins at {start:.3} mm above the tip, below the shank's end at {below} mm",
                        file.name
                    );
                    let help = "z of the file is 0 at the gauge point and rises to the spindle, in mm; the holder is below";
                    faults.push(self.places.fault(&file.key, what).with_help(help));
                }
                Ok(profile) => tool.holder = profile,
                Err(what) => {
                    faults.push(self.places.fault(&file.key, format!("{}: {what}", file.name)));
                }
            }
        }
        // The first operation's tool is the job's own: its file is reported once.
        faults.dedup();
        if faults.is_empty() { Ok(self) } else { Err(faults.into()) }
    }

    /// Returns one fault for each holder whose file was not read.
    pub(super) fn unread_holders(&self) -> Vec<Diagnostic> {
        let tools = std::iter::once(&self.tool).chain(&self.other_tools);
        let tools = tools.chain(self.operations.iter().map(|operation| &operation.tool));
        let files = tools.filter_map(|tool| tool.holder_file.as_ref());
        let unread = |file: &HolderFile| {
            self.places
                .fault(&file.key, format!("{}: the file of the holder was not read", file.name))
        };
        files.map(unread).collect()
    }
}

/// Returns the profile of a holder below the gauge point, `[height above the tip, radius]` \[mm\], for a tool of a length
/// \[mm\]. In the triangles z is the tool axis, 0 at the gauge point, and rises to the spindle.
///
/// # Errors
///
/// [`VerifyError::Stock`] for triangles that are not closed, or of which nothing is between gauge point and tip.
pub fn holder_profile(mesh: &Mesh, length: f64) -> Result<Vec<[f64; 2]>, VerifyError> {
    Fixture::new(&Solid::Mesh(mesh.clone()), TOLERANCE)?;
    let mut chords = Vec::new();
    for triangle in &mesh.triangles {
        let corners =
            triangle.map(|corner| mesh.vertices.get(corner as usize).map(|p| [p.x, p.y, p.z]));
        let [Some(a), Some(b), Some(c)] = corners else { continue };
        for edge in [[a, b], [b, c], [c, a]] {
            add_chords(edge, HALVINGS, &mut chords);
        }
    }
    let profile = simpler(&steps(&chords, length));
    if profile.is_empty() {
        let what = "has nothing between the gauge point (z = 0) and the tip of the tool; z rises to the spindle, in mm";
        return Err(VerifyError::Stock { what: what.to_owned() });
    }
    Ok(profile)
}

/// Part of an edge: heights and radii of its ends, the lower one first.
type Chord = [[f64; 2]; 2];

/// Divides an edge until its chords are as near to it as asked for.
fn add_chords([a, b]: [[f64; 3]; 2], halvings: u32, chords: &mut Vec<Chord>) {
    let middle = [0, 1, 2].map(|k| 0.5 * (a[k] + b[k]));
    let [from, to, at] = [a, b, middle].map(|p| math::hypot(p[0], p[1]));
    if halvings > 0 && 0.5 * (from + to) - at > TOLERANCE {
        add_chords([a, middle], halvings - 1, chords);
        add_chords([middle, b], halvings - 1, chords);
        return;
    }
    let (one, other) = ([a[2], from], [b[2], to]);
    chords.push(if a[2] <= b[2] { [one, other] } else { [other, one] });
}

/// Returns the largest radius of all chords, at both ends of every interval of heights, above the tip.
fn steps(chords: &[Chord], length: f64) -> Vec<[f64; 2]> {
    let heights = heights(chords, length);
    let mut radii = vec![[0.0_f64; 2]; heights.len().saturating_sub(1)];
    for [[low, from], [high, to]] in chords {
        let first = heights.partition_point(|z| *z <= low + ALIKE).saturating_sub(1);
        for (ends, radius) in heights.windows(2).zip(&mut radii).skip(first) {
            let &[bottom, top] = ends else { continue };
            if bottom >= *high {
                break;
            }
            // A level edge bounds triangles that reach above or below it.
            if bottom >= high - ALIKE || top <= low + ALIKE {
                continue;
            }
            let slope = (to - from) / (high - low).max(ALIKE);
            let ends = [bottom, top].map(|z| from + slope * (z.clamp(*low, *high) - low));
            // Where a chord ends within the interval, all of the interval counts.
            let inside = *low > bottom + ALIKE || *high < top - ALIKE;
            let ends = if inside { [ends[0].max(ends[1]); 2] } else { ends };
            *radius = [radius[0].max(ends[0]), radius[1].max(ends[1])];
        }
    }
    let points = heights.windows(2).zip(radii).flat_map(|(ends, radius)| {
        let at = |k: usize| [ends[k] + length, radius[k].max(LEAST_RADIUS)];
        [at(0), at(1)]
    });
    points.collect()
}

/// Returns the heights at which chords end, between the tip and the gauge point, ascending.
fn heights(chords: &[Chord], length: f64) -> Vec<f64> {
    let mut all: Vec<f64> = chords.iter().flatten().map(|[z, _]| z.clamp(-length, 0.0)).collect();
    all.sort_by(f64::total_cmp);
    all.dedup_by(|next, last| *next - *last <= ALIKE);
    let (Some(low), Some(high)) = (all.first().copied(), all.last().copied()) else {
        return Vec::new();
    };
    if all.len() > MOST_HEIGHTS {
        let step = (high - low) / MOST_HEIGHTS as f64;
        all.dedup_by(|next, last| *next - *last < step && *next < high);
    }
    all
}

/// Leaves out points of a profile that are below the line between those that stay, by no more than the tolerance.
fn simpler(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut kept: Vec<[f64; 2]> = points.first().copied().into_iter().collect();
    let mut from = 0;
    while from + 1 < points.len() {
        let mut to = from + 1;
        while to + 1 < points.len() && encloses(points.get(from..=to + 1).unwrap_or_default()) {
            to += 1;
        }
        kept.extend(points.get(to));
        from = to;
    }
    kept.dedup();
    kept
}

/// Returns true if the line between the ends of some points is on or above all others, by no more than the tolerance.
fn encloses(points: &[[f64; 2]]) -> bool {
    let (Some([z0, r0]), Some([z1, r1])) = (points.first(), points.last()) else { return false };
    let slope = (r1 - r0) / (z1 - z0);
    points.iter().all(|[z, r]| {
        let above = r0 + slope * (z - z0) - r;
        (-ALIKE..=TOLERANCE).contains(&above)
    })
}
