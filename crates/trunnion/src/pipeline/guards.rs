//! Faces that the tool keeps off while passes and links are planned: those of the part, and those of fixtures.
//!
//! A fixture is planned round as a larger one: by the clearance that moves must keep, by what the real one may stand
//! beyond its solid, and by the tolerance of the passes. The check of the programs knows the fixture itself.

use super::fixtures::Held;
use super::job::Job;
use crate::math;
use crate::surface::{
    CylinderSurface, Face, FaceIndex, PlaneSurface, Surface, SurfaceFrame, TrimCurve, TrimLoop,
};
use crate::types::Mesh;
use crate::verify::Solid;
use nalgebra::{Point3, Unit, Vector3};
use std::f64::consts::TAU;

/// Triangles of a fixture that planning keeps off; one with more is checked only.
const MOST_TRIANGLES: usize = 600;

/// Corners of the polygon that stands for the disc of a cylinder.
const CORNERS: u32 = 48;

/// Gap by which a trim loop may fail to close \[mm\]: all are built closed.
const CLOSED: f64 = 1e-9;

/// Returns all faces that an operation keeps off, without those that it cuts.
pub(super) fn guarded_faces(job: &Job) -> Vec<FaceIndex> {
    job.others.iter().cloned().chain(fixture_faces(job)).collect()
}

/// Returns boxes that enclose the fixtures, larger by the clearance: links travel above them.
pub(super) fn fixture_boxes(job: &Job) -> Vec<[Point3<f64>; 2]> {
    let solids =
        job.fixtures.iter().filter_map(|held| Some((held, held.solid.as_ref()?.bounds()?)));
    solids
        .map(|(held, [low, high])| {
            let out = Vector3::repeat(job.file.fixture_clearance + held.allowance);
            [low - out, high + out]
        })
        .collect()
}

/// Warns about fixtures that passes are not planned round.
pub(super) fn unplanned(job: &Job) -> Vec<String> {
    let unplanned = job.fixtures.iter().filter(|held| is_only_checked(held));
    let line = |held: &Held| {
        format!(
            "fixture {} has more than {MOST_TRIANGLES} triangles: passes are not planned round it, it is only checked; a box \
             or a cylinder round it is avoided",
            held.name
        )
    };
    unplanned.map(line).collect()
}

/// Returns true for a fixture of more triangles than planning keeps off.
fn is_only_checked(held: &Held) -> bool {
    matches!(&held.solid, Some(Solid::Mesh(mesh)) if mesh.triangles.len() > MOST_TRIANGLES)
}

/// Replaces the numbers that fixtures have as faces by their names.
pub(super) fn with_fixture_names(job: &Job, text: &str) -> String {
    let names: Vec<&str> = job.fixtures.iter().map(|held| held.name.as_str()).collect();
    with_names(text, first_number(job), &names)
}

/// Replaces faces with the numbers from `first` on by fixtures of these names.
fn with_names(text: &str, first: usize, names: &[&str]) -> String {
    const WORD: &str = "face ";
    let mut parts = text.split(WORD);
    let mut named = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let digits = part.len() - part.trim_start_matches(|c: char| c.is_ascii_digit()).len();
        let (number, rest) = part.split_at(digits);
        let place = number.parse().ok().and_then(|number: usize| number.checked_sub(first));
        let is_word = !named.ends_with(char::is_alphanumeric);
        match place.and_then(|place| names.get(place)).filter(|_| is_word) {
            Some(name) => named.extend(["fixture ", name, rest]),
            None => named.extend([WORD, part]),
        }
    }
    named
}

fn first_number(job: &Job) -> usize {
    let numbers = job.faces.iter().chain(&job.others).map(|face| face.face().number);
    numbers.max().unwrap_or(0) + 1
}

fn fixture_faces(job: &Job) -> Vec<FaceIndex> {
    let larger = job.file.fixture_clearance + job.budget.total;
    let mut faces = Vec::new();
    for (number, held) in (first_number(job)..).zip(&job.fixtures) {
        let parts = parts(held, larger + held.allowance).into_iter().flatten();
        // A part too thin to have a face, such as a triangle without area, holds nothing off.
        faces.extend(parts.filter_map(|part| part.face(number)));
    }
    faces
}

/// Surface of a fixture, normal outwards, with the corners of its trim.
struct FixturePart {
    surface: Surface,
    corners: Vec<[f64; 2]>,
}

impl FixturePart {
    fn face(self, number: usize) -> Option<FaceIndex> {
        let closed: Vec<[f64; 2]> =
            self.corners.iter().chain(self.corners.first()).copied().collect();
        let curve = TrimCurve::polyline(&closed).ok()?;
        let trim = TrimLoop::new(vec![curve], self.surface.periods(), CLOSED).ok()?;
        Face::new(number, self.surface, vec![trim]).and_then(FaceIndex::new).ok()
    }

    /// Creates a plane polygon from points around it, counter-clockwise seen from outside, moved outwards by a distance.
    fn polygon(points: &[Point3<f64>], out: f64) -> Option<Self> {
        let (first, second, third) = (points.first()?, points.get(1)?, points.get(2)?);
        let along = second - first;
        let normal = along.cross(&(third - second)).try_normalize(f64::MIN_POSITIVE)?;
        let frame = SurfaceFrame::new(first + normal * out, normal, along).ok()?;
        let corner = |p: &Point3<f64>| {
            let off = p - first;
            [off.dot(&frame.x()), off.dot(&frame.y())]
        };
        let corners = points.iter().map(corner).collect();
        Some(Self { surface: Surface::Plane(PlaneSurface { frame }), corners })
    }
}

/// Returns the surfaces of a fixture, larger by a distance \[mm\]; `None` without a solid, or with too many triangles.
fn parts(held: &Held, larger: f64) -> Option<Vec<FixturePart>> {
    match held.solid.as_ref()? {
        Solid::Box { low, high } => {
            let out = Vector3::repeat(larger);
            Some(of_box(&(low - out), &(high + out)))
        }
        Solid::Cylinder { base, radius, height } => {
            let base = base - Vector3::z() * larger;
            Some(of_cylinder(base, radius + larger, height + 2.0 * larger))
        }
        Solid::Mesh(_) if is_only_checked(held) => None,
        Solid::Mesh(mesh) => Some(of_mesh(mesh, larger)),
    }
}

fn of_box(low: &Point3<f64>, high: &Point3<f64>) -> Vec<FixturePart> {
    let side = |k: usize, end: f64| {
        // Round the side with the axes after `k` in cyclic order; on the low side the other way round.
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        let at = |a: f64, b: f64| {
            let mut point = *low;
            point[k] += end * (high[k] - low[k]);
            point[i] += a * (high[i] - low[i]);
            point[j] += b * (high[j] - low[j]);
            point
        };
        let mut corners = [at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0), at(0.0, 1.0)];
        if end < 0.5 {
            corners.reverse();
        }
        FixturePart::polygon(&corners, 0.0)
    };
    (0..3).flat_map(|k| [0.0, 1.0].map(|end| side(k, end))).flatten().collect()
}

fn of_cylinder(base: Point3<f64>, radius: f64, height: f64) -> Vec<FixturePart> {
    // A polygon round the disc holds all of it.
    let outside = radius / math::cos(0.5 * TAU / f64::from(CORNERS));
    let ring = |z: f64, way: f64| -> Vec<Point3<f64>> {
        let at = |i: u32| {
            let (sin, cos) = math::sin_cos(way * TAU * f64::from(i) / f64::from(CORNERS));
            base + Vector3::new(outside * cos, outside * sin, z)
        };
        (0..CORNERS).map(at).collect()
    };
    let discs = [ring(height, 1.0), ring(0.0, -1.0)];
    let discs = discs.iter().filter_map(|points| FixturePart::polygon(points, 0.0));
    let frame = SurfaceFrame::new(base, Vector3::z(), Vector3::x()).ok();
    let wall = frame.and_then(|frame| CylinderSurface::new(frame, radius).ok());
    let wall = wall.map(|surface| FixturePart {
        surface: Surface::Cylinder(surface),
        corners: vec![[0.0, 0.0], [TAU, 0.0], [TAU, height], [0.0, height]],
    });
    discs.chain(wall).collect()
}

fn of_mesh(mesh: &Mesh, larger: f64) -> Vec<FixturePart> {
    let corners = |triangle: &[u32; 3]| -> Option<[Point3<f64>; 3]> {
        let [a, b, c] = triangle.map(|corner| mesh.vertices.get(corner as usize).copied());
        Some([a?, b?, c?])
    };
    let triangles: Vec<[Point3<f64>; 3]> = mesh.triangles.iter().filter_map(corners).collect();
    // Six times the volume by the divergence theorem: negative where the triangles are turned inside out.
    let volume: f64 =
        triangles.iter().map(|[a, b, c]| a.coords.dot(&b.coords.cross(&c.coords))).sum();
    let outwards = |[a, b, c]: [Point3<f64>; 3]| if volume < 0.0 { [a, c, b] } else { [a, b, c] };
    let sides = FlatSide::of(triangles.into_iter().map(outwards));
    let part = |corners: Vec<Point3<f64>>| FixturePart::polygon(&wider(&corners, larger)?, larger);
    sides.iter().flat_map(FlatSide::outlines).filter_map(part).collect()
}

/// Triangles of a mesh in one plane.
struct FlatSide {
    normal: Unit<Vector3<f64>>,
    /// Distance of the plane from the origin \[mm\].
    offset: f64,
    triangles: Vec<[Point3<f64>; 3]>,
    area: f64,
}

/// Largest sine of the angle between normals of one plane, and largest distance of its triangles \[mm\].
const FLAT: f64 = 1e-7;

/// Share by which the hull of a flat side may exceed the side itself.
const CONVEX: f64 = 1e-4;

impl FlatSide {
    /// Collects triangles by their planes; those without area have none.
    fn of(triangles: impl Iterator<Item = [Point3<f64>; 3]>) -> Vec<Self> {
        let mut sides: Vec<Self> = Vec::new();
        for triangle in triangles {
            let [a, b, c] = &triangle;
            let across = (b - a).cross(&(c - b));
            let Some(normal) = Unit::try_new(across, f64::MIN_POSITIVE) else { continue };
            let (offset, area) = (normal.dot(&a.coords), 0.5 * across.norm());
            let same = |side: &&mut Self| {
                (side.normal.into_inner() - normal.into_inner()).norm() < FLAT
                    && (side.offset - offset).abs() < FLAT
            };
            match sides.iter_mut().find(same) {
                Some(side) => {
                    side.triangles.push(triangle);
                    side.area += area;
                }
                None => sides.push(Self { normal, offset, triangles: vec![triangle], area }),
            }
        }
        sides
    }

    /// Returns polygons that cover the side, counter-clockwise seen from outside: one if the side is convex, else its
    /// triangles.
    fn outlines(&self) -> Vec<Vec<Point3<f64>>> {
        match self.hull() {
            Some(hull) => vec![hull],
            None => self.triangles.iter().map(|corners| corners.to_vec()).collect(),
        }
    }

    /// Returns the convex hull of the side if it is hardly larger than the side.
    fn hull(&self) -> Option<Vec<Point3<f64>>> {
        let first = self.triangles.first()?[0];
        let frame =
            SurfaceFrame::new(first, self.normal.into_inner(), self.triangles.first()?[1] - first)
                .ok()?;
        let flat = |p: &Point3<f64>| [(p - first).dot(&frame.x()), (p - first).dot(&frame.y())];
        let points: Vec<[f64; 2]> = self.triangles.iter().flatten().map(flat).collect();
        let hull = convex_hull(points);
        let area: f64 = hull
            .iter()
            .zip(hull.iter().cycle().skip(1))
            .map(|([x, y], [u, v])| 0.5 * (x * v - u * y))
            .sum();
        let back = |[x, y]: [f64; 2]| first + frame.x().scale(x) + frame.y().scale(y);
        (area <= (1.0 + CONVEX) * self.area).then(|| hull.into_iter().map(back).collect())
    }
}

/// Returns the convex hull of points, counter-clockwise (monotone chain of Andrew).
fn convex_hull(mut points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    points.dedup_by(|a, b| (a[0] - b[0]).abs() < FLAT && (a[1] - b[1]).abs() < FLAT);
    let half = |points: &mut dyn Iterator<Item = [f64; 2]>| {
        let mut chain: Vec<[f64; 2]> = Vec::new();
        for p in points {
            while let [.., a, b] = chain[..]
                && (b[0] - a[0]) * (p[1] - b[1]) - (b[1] - a[1]) * (p[0] - b[0]) <= FLAT * FLAT
            {
                chain.pop();
            }
            chain.push(p);
        }
        // The last point is the first of the other half.
        chain.pop();
        chain
    };
    let mut hull = half(&mut points.iter().copied());
    hull.extend(half(&mut points.iter().rev().copied()));
    hull
}

/// Returns a convex polygon with its sides moved outwards, two corners for each: moved along its normal as well, it meets
/// a neighbour round an edge of up to 90 degrees.
fn wider(corners: &[Point3<f64>], by: f64) -> Option<Vec<Point3<f64>>> {
    let [a, b, c] = [corners.first()?, corners.get(1)?, corners.get(2)?];
    let normal = (b - a).cross(&(c - b)).try_normalize(f64::MIN_POSITIVE)?;
    let mut out = Vec::with_capacity(2 * corners.len());
    for (from, to) in corners.iter().zip(corners.iter().cycle().skip(1)) {
        let aside = (to - from).cross(&normal).try_normalize(f64::MIN_POSITIVE)? * by;
        out.extend([from + aside, to + aside]);
    }
    Some(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cutter::ConvexSolid;
    use crate::types::ToolPose;

    fn held(solid: Solid) -> Held {
        Held { name: "clamp".to_owned(), solid: Some(solid), allowance: 0.0 }
    }

    /// Points of all faces and their normals, which look out of a solid.
    fn faces(solid: Solid, larger: f64) -> Vec<FaceIndex> {
        let parts = parts(&held(solid), larger).unwrap();
        parts.into_iter().map(|part| part.face(7).unwrap()).collect()
    }

    #[test]
    fn a_box_and_a_cylinder_are_closed_by_faces_that_look_out() {
        let box_ =
            Solid::Box { low: Point3::new(1.0, 2.0, 3.0), high: Point3::new(4.0, 8.0, 12.0) };
        let cylinder =
            Solid::Cylinder { base: Point3::new(1.0, 2.0, 3.0), radius: 4.0, height: 5.0 };
        for (solid, count, middle) in
            [(box_, 6, Point3::new(2.5, 5.0, 7.5)), (cylinder, 3, Point3::new(1.0, 2.0, 5.5))]
        {
            let faces = faces(solid, 0.5);
            assert_eq!(faces.len(), count);
            for face in &faces {
                let [u, v] = face.face().bounds().map(|range| range.middle());
                let (p, n) = (face.face().point(u, v), face.face().normal(u, v).unwrap());
                assert!((p - middle).dot(&n) > 1.0, "{p} {n:?}");
            }
        }
    }

    #[test]
    fn a_flat_side_of_many_triangles_is_one_face() {
        // Two squares in one plane, each of two triangles, and a triangle beside them that makes the outline an L.
        let p = |x: f64, y: f64| Point3::new(x, y, 3.0);
        let squares =
            [[p(0.0, 0.0), p(4.0, 0.0), p(4.0, 4.0)], [p(0.0, 0.0), p(4.0, 4.0), p(0.0, 4.0)]];
        let more = squares.map(|corners| corners.map(|q| q + Vector3::x() * 4.0));
        let all: Vec<_> = squares.into_iter().chain(more).collect();
        let sides = FlatSide::of(all.iter().copied());
        assert_eq!(sides.len(), 1);
        let outlines = sides[0].outlines();
        assert_eq!((outlines.len(), outlines[0].len()), (1, 4));

        let wide = wider(&outlines[0], 0.5).unwrap();
        assert!(wide.iter().all(|q| (q.x - 4.0).abs() <= 4.5 && (q.y - 2.0).abs() <= 2.5));
        let notch = [p(0.0, 4.0), p(4.0, 4.0), p(0.0, 8.0)];
        let sides = FlatSide::of(all.into_iter().chain([notch]));
        assert_eq!((sides.len(), sides[0].outlines().len()), (1, 5));
    }

    #[test]
    fn every_fixture_has_its_own_name() {
        let names = ["a", "b", "c", "d", "e", "f", "g", "h", "face 3", "i", "j"];
        let text = "face 1 gouges face 2, face 10 and surface 12; face 12 and face 30 face 11";
        let named = "face 1 gouges fixture a, fixture face 3 and surface 12; fixture j and face 30 fixture i";
        assert_eq!(with_names(text, 2, &names), named);
    }

    #[test]
    fn a_mesh_looks_out_whichever_way_its_triangles_turn() {
        let vertices = [[0.0, 0.0, 0.0], [9.0, 0.0, 0.0], [0.0, 9.0, 0.0], [0.0, 0.0, 9.0]];
        let out = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        let inside_out: Vec<[u32; 3]> = out.iter().map(|&[a, b, c]| [a, c, b]).collect();
        for triangles in [out, inside_out] {
            let mesh = Mesh { vertices: vertices.map(Point3::from).to_vec(), triangles };
            let middle = Point3::new(2.0, 2.0, 2.0);
            for face in faces(Solid::Mesh(mesh), 0.5) {
                let [u, v] = face.face().bounds().map(|range| range.at(0.3));
                let (p, n) = (face.face().point(u, v), face.face().normal(u, v).unwrap());
                assert!((p - middle).dot(&n) > 0.5, "{p} {n:?}");
                // A ball out there is clear of the fixture itself.
                let pose = ToolPose { tip: p, axis: n };
                assert!(ConvexSolid::ball(0.4).distance(&(p - n.scale(0.5)), &pose) > 0.0);
            }
        }
    }
}
