//! Faces of a file: their units, placements and orientation, and the edges around them.

use super::curve::StepCurve;
use super::model::FaceLoss;
use super::model::MAX_CHAIN;
use super::model::Read;
use super::model::RecordFields;
use super::model::StepModel;
use super::model::UnitScale;
use super::model::loss;
use super::part21::StepExchange;
use super::part21::StepValue;
use super::placement::PartPlacements;
use super::units;
use nalgebra::Isometry3;
use nalgebra::Point3;
use std::collections::HashMap;
use std::collections::HashSet;

/// Names of a face entity.
const FACES: [&str; 2] = ["ADVANCED_FACE", "FACE_SURFACE"];
/// Names of a set of faces.
const SHELLS: [&str; 3] = ["CLOSED_SHELL", "OPEN_SHELL", "CONNECTED_FACE_SET"];
/// Names of a set of faces taken in its own or the opposite sense.
const ORIENTED: [&str; 2] = ["ORIENTED_CLOSED_SHELL", "ORIENTED_OPEN_SHELL"];

/// A face before its geometry is read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FaceOutline {
    /// Entity of the face.
    pub(super) id: u64,
    /// Units it is written in.
    pub(super) scale: UnitScale,
    /// Taken in the opposite sense by its shell.
    pub(super) reversed: bool,
    /// `file_from_representation`
    pub(super) place: Isometry3<f64>,
}

/// Use of a face by a shell.
#[derive(Debug, Clone, Copy)]
struct FaceUse {
    /// Representation and its context.
    place: Option<[u64; 2]>,
    reversed: bool,
}

/// In no representation.
const LOOSE: FaceUse = FaceUse { place: None, reversed: false };

/// Lists all faces in file order, once for every placement, and everything doubtful.
pub(super) fn outlines(exchange: &StepExchange) -> (Vec<FaceOutline>, Vec<FaceLoss>) {
    let (placements, mut losses) = PartPlacements::read(exchange);
    let default = units::first(exchange);
    let uses = uses(exchange, &mut losses);
    let mut known =
        RepresentationCache { exchange, placements, losses: &mut losses, found: HashMap::new() };
    let mut outlines = Vec::new();
    for instance in &exchange.instances {
        if !FACES.iter().any(|name| instance.part(name).is_some()) {
            continue;
        }
        let id = instance.id;
        let used = uses.get(&id).copied().unwrap_or_else(|| {
            let message = "the face belongs to no shell; its side is taken from the face alone";
            known.losses.push(FaceLoss { entity: id, message: message.to_owned() });
            LOOSE
        });
        // A representation without units takes the first units of the file.
        let (scale, places) = known.of(used);
        let scale = scale.or(default).unwrap_or(super::model::ASSUMED);
        let placed = |&place| FaceOutline { id, scale, reversed: used.reversed, place };
        outlines.extend(places.iter().map(placed));
    }
    if default.is_none() && !outlines.is_empty() {
        let message = "the file states no unit of length; millimetres are assumed";
        losses.push(FaceLoss { entity: 0, message: message.to_owned() });
    }
    (outlines, losses)
}

/// Units of a representation, if stated, and the places where it stands.
type ContextUnits = (Option<UnitScale>, Vec<Isometry3<f64>>);

/// Units and places of representations, found once each.
struct RepresentationCache<'a, 'b> {
    exchange: &'a StepExchange,
    placements: PartPlacements,
    losses: &'b mut Vec<FaceLoss>,
    found: HashMap<u64, ContextUnits>,
}

impl RepresentationCache<'_, '_> {
    fn of(&mut self, used: FaceUse) -> ContextUnits {
        let Some([representation, context]) = used.place else {
            return (None, vec![Isometry3::identity()]);
        };
        if let Some(found) = self.found.get(&representation) {
            return found.clone();
        }
        let scale = units::scale(self.exchange, context).unwrap_or_else(|loss| {
            self.losses.push(loss);
            None
        });
        let places = self.placements.of(representation).unwrap_or_else(|loss| {
            self.losses.push(loss);
            vec![Isometry3::identity()]
        });
        self.found.insert(representation, (scale, places.clone()));
        (scale, places)
    }
}

/// Finds the first use of each face.
fn uses(exchange: &StepExchange, losses: &mut Vec<FaceLoss>) -> HashMap<u64, FaceUse> {
    let mut walk = ShellWalk { exchange, uses: HashMap::new(), visited: HashSet::new(), losses };
    walk.representations();
    walk.loose_shells();
    walk.uses
}

/// From representations down to faces.
struct ShellWalk<'a, 'b> {
    exchange: &'a StepExchange,
    uses: HashMap<u64, FaceUse>,
    /// Shells read.
    visited: HashSet<u64>,
    losses: &'b mut Vec<FaceLoss>,
}

impl ShellWalk<'_, '_> {
    fn note<T>(&mut self, read: Read<T>) -> Option<T> {
        match read {
            Ok(value) => Some(value),
            Err(loss) => {
                self.losses.push(loss);
                None
            }
        }
    }

    /// Follows the items of every `..._REPRESENTATION(name, (items), context)`.
    fn representations(&mut self) {
        let exchange = self.exchange;
        for instance in &exchange.instances {
            let Some(fields) = StepModel::simple(instance) else { continue };
            if !fields.name.ends_with("REPRESENTATION") {
                continue;
            }
            let (Some(items), Some(context)) = (
                fields.values.get(1).and_then(StepValue::list),
                fields.values.get(2).and_then(StepValue::reference),
            ) else {
                continue;
            };
            for item in items.iter().filter_map(StepValue::reference) {
                self.item(item, instance.id, context);
            }
        }
    }

    fn item(&mut self, id: u64, representation: u64, context: u64) {
        let Some(instance) = self.exchange.get(id) else { return };
        let Some(fields) = StepModel::simple(instance) else { return };
        // Solids and surface models alike are sets of shells.
        let shells = match fields.name {
            "MANIFOLD_SOLID_BREP" | "FACETED_BREP" => fields.reference(1).map(|id| vec![id]),
            "BREP_WITH_VOIDS" => fields.reference(1).and_then(|outer| {
                let mut all = vec![outer];
                all.extend(fields.references(2)?);
                Ok(all)
            }),
            "SHELL_BASED_SURFACE_MODEL" | "FACE_BASED_SURFACE_MODEL" => fields.references(1),
            _ => return,
        };
        for shell in self.note(shells).unwrap_or_default() {
            let place = Some([representation, context]);
            self.shell(shell, id, FaceUse { place, reversed: false }, 0);
        }
    }

    fn shell(&mut self, id: u64, from: u64, used: FaceUse, depth: usize) {
        let names: Vec<&str> = SHELLS.iter().chain(&ORIENTED).copied().collect();
        let Some(fields) = self.exchange.get(id).map_or_else(
            || self.note(loss(from, format!("refers to #{id}, which the file does not define"))),
            |instance| names.iter().find_map(|name| StepModel::part(instance, name)),
        ) else {
            return;
        };
        if ORIENTED.contains(&fields.name) {
            let inner = fields.reference(2).and_then(|inner| Ok((inner, fields.truth(3)?)));
            if depth < MAX_CHAIN
                && let Some((inner, forward)) = self.note(inner)
            {
                // Two reversals cancel: reversed once more unless the orientation is `.T.`.
                let reversed = used.reversed == forward;
                self.shell(inner, id, FaceUse { reversed, ..used }, depth + 1);
            }
            return;
        }
        // A shell shared by two solids is read once, with the sense of its first use.
        if !self.visited.insert(id) {
            return;
        }
        let faces = fields.references(1);
        let faces = self.note(faces).unwrap_or_default();
        if faces.is_empty() {
            let message = format!("the {} is empty", fields.name);
            self.losses.push(FaceLoss { entity: id, message });
        }
        for face in faces {
            self.face(face, id, used);
        }
    }

    fn face(&mut self, id: u64, from: u64, used: FaceUse) {
        let model = StepModel::plain(self.exchange);
        let Some(instance) = self.note(model.instance(id, from)) else { return };
        if FACES.iter().any(|name| instance.part(name).is_some()) {
            // A face of two shells keeps the first: its side would be ambiguous otherwise.
            self.uses.entry(id).or_insert(used);
            return;
        }
        let Some(fields) = StepModel::part(instance, "ORIENTED_FACE") else {
            let message = format!("{} is not a face this reader knows", instance.kind());
            self.losses.push(FaceLoss { entity: id, message });
            return;
        };
        let inner = fields.reference(2).and_then(|inner| Ok((inner, fields.truth(3)?)));
        if let Some((inner, forward)) = self.note(inner) {
            self.uses
                .entry(inner)
                .or_insert(FaceUse { reversed: used.reversed == forward, ..used });
        }
    }

    /// Reads shells that no representation reaches.
    fn loose_shells(&mut self) {
        let exchange = self.exchange;
        for instance in &exchange.instances {
            if SHELLS.iter().any(|name| instance.part(name).is_some()) {
                self.shell(instance.id, instance.id, LOOSE, 0);
            }
        }
    }
}

/// An edge as its loop uses it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct LoopEdge {
    /// Entity of the edge curve.
    pub(super) id: u64,
    /// Its curve.
    pub(super) curve: StepCurve,
    /// Parameters at the start and the end, in the direction of the loop.
    pub(super) range: [f64; 2],
    /// Its vertices, likewise.
    pub(super) ends: [Point3<f64>; 2],
}

/// The boundary of a face before it is brought into the surface's parameters.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct FaceBoundary {
    /// Entity of the loop.
    pub(super) id: u64,
    /// Edges in order; empty for a loop that is a single vertex.
    pub(super) edges: Vec<LoopEdge>,
}

/// Contents of an `ADVANCED_FACE`.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct FaceTopology {
    /// Entity of the surface.
    pub(super) surface: u64,
    /// The face looks where the surface's normal points.
    pub(super) same_sense: bool,
    /// Loops, counter-clockwise about the *surface's* normal: the face is on their left.
    pub(super) boundaries: Vec<FaceBoundary>,
}

impl FaceTopology {
    /// Turns the face over to a surface whose normal points the other way.
    pub(super) fn turn_over(&mut self) {
        self.same_sense = !self.same_sense;
        for boundary in &mut self.boundaries {
            boundary.reverse();
        }
    }
}

impl FaceBoundary {
    fn reverse(&mut self) {
        self.edges.reverse();
        for edge in &mut self.edges {
            edge.range.reverse();
            edge.ends.reverse();
        }
    }
}

impl<'a> StepModel<'a> {
    /// Reads a face; points closer than `tolerance` \[mm\] count as one.
    pub(super) fn skin(&self, id: u64, tolerance: f64) -> Read<FaceTopology> {
        let fields = self.named(id, id, &FACES)?;
        let same_sense = fields.truth(3)?;
        let mut boundaries = Vec::new();
        for bound in fields.references(1)? {
            let bound = self.named(bound, id, &["FACE_OUTER_BOUND", "FACE_BOUND"])?;
            let mut boundary = self.boundary(bound.reference(1)?, bound.id, tolerance)?;
            // Listed counter-clockwise about the face's normal once the bound's own flag is obeyed.
            if bound.truth(2)? != same_sense {
                boundary.reverse();
            }
            boundaries.push(boundary);
        }
        Ok(FaceTopology { surface: fields.reference(2)?, same_sense, boundaries })
    }

    fn boundary(&self, id: u64, from: u64, tolerance: f64) -> Read<FaceBoundary> {
        let fields = self.named(id, from, &["EDGE_LOOP", "VERTEX_LOOP", "POLY_LOOP"])?;
        let edges = match fields.name {
            "VERTEX_LOOP" => Vec::new(),
            "POLY_LOOP" => self.poly_loop(fields)?,
            _ => {
                let ids = fields.references(1)?;
                if ids.is_empty() {
                    return loss(id, "the loop has no edge");
                }
                let read = |edge: &u64| self.oriented_edge(*edge, id, tolerance);
                ids.iter().map(read).collect::<Read<Vec<LoopEdge>>>()?
            }
        };
        Ok(FaceBoundary { id, edges })
    }

    fn poly_loop(&self, fields: RecordFields<'a>) -> Read<Vec<LoopEdge>> {
        let ids = fields.references(1)?;
        let corners: Vec<Point3<f64>> =
            ids.iter().map(|&id| self.point(id, fields.id)).collect::<Read<_>>()?;
        let next = corners.iter().cycle().skip(1);
        // Faceted solids: straight edges between the points, closed by the last.
        let sides = corners.iter().zip(next).map(|(a, b)| {
            let curve = StepCurve::Line { origin: *a, direction: b - a };
            LoopEdge { id: fields.id, curve, range: [0.0, 1.0], ends: [*a, *b] }
        });
        Ok(sides.collect())
    }

    fn vertex(&self, id: u64, from: u64) -> Read<Point3<f64>> {
        let fields = self.named(id, from, &["VERTEX_POINT"])?;
        self.point(fields.reference(1)?, id)
    }

    fn oriented_edge(&self, id: u64, from: u64, tolerance: f64) -> Read<LoopEdge> {
        let oriented = self.named(id, from, &["ORIENTED_EDGE", "EDGE_CURVE"])?;
        let (edge, forward) = if oriented.name == "EDGE_CURVE" {
            (oriented, true)
        } else {
            (self.named(oriented.reference(3)?, id, &["EDGE_CURVE"])?, oriented.truth(4)?)
        };
        let start = self.vertex(edge.reference(1)?, edge.id)?;
        let end = self.vertex(edge.reference(2)?, edge.id)?;
        let curve = self.curve(edge.reference(3)?, edge.id)?;
        // The edge runs from start to end; the curve the same way only if its sense is the same.
        let same = edge.truth(4)?;
        // On a closed curve the arc from start to end differs from that from end to start.
        let mut range = if same {
            curve.range(&start, &end, tolerance)
        } else {
            let [a, b] = curve.range(&end, &start, tolerance);
            [b, a]
        };
        // The loop may use the edge against its own direction.
        let mut ends = [start, end];
        if !forward {
            range.reverse();
            ends.reverse();
        }
        let finite = range.iter().all(|t| t.is_finite());
        if finite { Ok(LoopEdge { id: edge.id, curve, range, ends }) } else { no_range(edge) }
    }
}

fn no_range(edge: RecordFields<'_>) -> Read<LoopEdge> {
    loss(edge.id, "the ends of the edge cannot be found on its curve")
}
